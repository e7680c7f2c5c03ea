//! Materials of model files: which take a tint, and which let light through.

use bevy::{gltf::GltfMaterial, prelude::*};

use super::pictures::Purpose;
use crate::level::model::Tint;

/// A material before tinting.
#[derive(Clone, Debug)]
pub(super) struct Look {
    /// In its file.
    pub(super) name: String,
    material: StandardMaterial,
    /// Does a placement's tint multiply its colour?
    pub(super) takes_tint: bool,
    is_impostor: bool,
}

/// Beginnings of names of materials that take a tint.
const TINTED: [&str; 6] = ["paint", "leaves", "needles", "blades", "fern", "grass"];
/// End of names of materials that hold many views of a model.
const IMPOSTOR: &str = "_impostor";

impl Look {
    /// A material called `name` of a file. Bevy's loader reads no translucency, so that it is told by names here.
    pub(super) fn new(file: &str, name: &str, gltf: &GltfMaterial) -> Self {
        let is_impostor = name.ends_with(IMPOSTOR);
        let is_leaf = !is_impostor && TINTED[1..].iter().any(|start| name.starts_with(start));
        let transmission = match file {
            "spruce" | "pine" => 0.0,
            _ if is_leaf => 0.4,
            _ => 0.0,
        };
        let material = StandardMaterial {
            base_color: gltf.base_color,
            base_color_texture: gltf.base_color_texture.clone(),
            emissive: gltf.emissive,
            // Cards have few normals: a shine on them is a shine of whole twigs.
            perceptual_roughness: if is_leaf { 0.9 } else { gltf.perceptual_roughness },
            metallic: gltf.metallic,
            // Bark, leaves and plaster are rough and dull; glass and paint are smooth.
            reflectance: match gltf.perceptual_roughness {
                _ if is_leaf || is_impostor => 0.12,
                rough if rough > 0.55 => 0.25,
                _ => 0.5,
            },
            normal_map_texture: gltf.normal_map_texture.clone(),
            diffuse_transmission: transmission,
            // Leaves have the crown's normals: turned ones would blacken the half that is seen from behind.
            double_sided: gltf.double_sided && !is_leaf && !is_impostor,
            cull_mode: if gltf.double_sided || is_impostor {
                None
            } else {
                gltf.cull_mode
            },
            alpha_mode: gltf.alpha_mode,
            ..default()
        };
        Self {
            name: name.to_owned(),
            material,
            takes_tint: is_impostor || TINTED.iter().any(|start| name.starts_with(start)),
            is_impostor,
        }
    }

    /// Its pictures and what they are for.
    pub(super) fn pictures(&mut self) -> [(&mut Option<Handle<Image>>, Purpose); 2] {
        let cutoff = match self.material.alpha_mode {
            AlphaMode::Mask(cutoff) => Some(cutoff),
            _ => None,
        };
        let levels = if self.is_impostor { IMPOSTOR_MIPS } else { u32::MAX };
        [
            (&mut self.material.base_color_texture, Purpose::Color { cutoff, levels }),
            (&mut self.material.normal_map_texture, Purpose::Normal { levels }),
        ]
    }

    /// Its pictures of colour and normals.
    pub(super) fn color_and_normal(&self) -> Option<[&Handle<Image>; 2]> {
        let material = &self.material;
        Some([
            material.base_color_texture.as_ref()?,
            material.normal_map_texture.as_ref()?,
        ])
    }

    /// The material with its colour multiplied; far ones let no light through, which
    /// is dear: with it in all levels the main pass of the forest took 3.6 s instead of 3.1 s on a software driver.
    pub(super) fn tinted(&self, Tint([r, g, b]): Tint, is_far: bool) -> StandardMaterial {
        let tint = Color::srgb_u8(r, g, b).to_linear();
        let base = self.material.base_color.to_linear();
        StandardMaterial {
            base_color: LinearRgba::new(
                base.red * tint.red,
                base.green * tint.green,
                base.blue * tint.blue,
                base.alpha,
            )
            .into(),
            diffuse_transmission: if is_far {
                0.0
            } else {
                self.material.diffuse_transmission
            },
            ..self.material.clone()
        }
    }
}

/// Views begin at multiples of eight texels: smaller mips would mix neighbours.
const IMPOSTOR_MIPS: u32 = 4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tints_multiply_in_linear_light_and_keep_alpha() {
        let gltf = GltfMaterial {
            base_color: Color::linear_rgba(0.5, 1.0, 0.25, 0.7),
            ..default()
        };
        let look = Look::new("car", "paint", &gltf);
        assert!(look.takes_tint);
        let color = look.tinted(Tint([255, 188, 0]), false).base_color.to_linear();
        // 188 is half the light.
        let expected = LinearRgba::new(0.5, 0.502_886, 0.0, 0.7);
        assert!(
            (color.to_vec4() - expected.to_vec4()).abs().max_element() < 1e-4,
            "{color:?}"
        );
    }

    #[test]
    fn leaves_let_light_through_and_keep_the_normals_of_their_crown() {
        let gltf = GltfMaterial {
            double_sided: true,
            cull_mode: None,
            alpha_mode: AlphaMode::Mask(0.5),
            ..default()
        };
        let leaves = Look::new("oak", "leaves", &gltf).tinted(Tint::WHITE, false);
        assert!(leaves.diffuse_transmission > 0.3 && !leaves.double_sided && leaves.cull_mode.is_none());
        assert_eq!(Look::new("spruce", "leaves", &gltf).material.diffuse_transmission, 0.0);
        assert_eq!(
            Look::new("oak", "leaves", &gltf)
                .tinted(Tint::WHITE, true)
                .diffuse_transmission,
            0.0
        );
        let awning = Look::new("shop", "cloth", &gltf);
        assert!(awning.material.double_sided && !awning.takes_tint && awning.material.diffuse_transmission == 0.0);
    }
}
