//! [`Dome`]: the sky over one place under one sun, in candela per square metre, and its pictures as cube maps.

use std::f64::consts::{FRAC_PI_2, PI};

use bevy::math::DVec3;

use super::{
    atmosphere::{self, Atmosphere, GROUND_RADIUS, Inscattering, mie_phase, rayleigh_phase},
    exposure::aces_fitted,
};

/// Lux of sunlight outside the air: the solar constant by the eye's sensitivity.
const SUN_LUX: f64 = 128_000.0;
/// Weights of linear RGB in luminance (ITU-R BT.709).
pub(super) const LUMA: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);
/// Altitude of the eye in kilometres.
const EYE: f64 = 0.3;
/// Reflectance of grass and earth, which lights everything from below.
const GROUND_ALBEDO: DVec3 = DVec3::new(0.16, 0.15, 0.10);
/// Share of the ground in sight that the sun reaches.
const SUNLIT_GROUND: f64 = 0.5;
/// Half of the angle under which the drawn sun is seen, in radians: wider than the true one, which a texel could not
/// hold.
const DISC: [f64; 2] = [0.010, 0.030];
/// Columns (azimuth from the sun) and rows (elevation) of the table.
const COLUMNS: usize = 9;
const ROWS: usize = 40;
/// Directions over which light is summed up.
const DIRECTIONS: usize = 512;

/// Clear sky: what comes from every direction.
#[derive(Clone, Debug)]
pub struct Dome {
    to_sun: DVec3,
    table: Vec<Inscattering>,
    /// Lux on a surface that faces the sun, linear RGB; black at night.
    pub sun_lux: DVec3,
    /// Lux on level ground from the sky alone.
    pub sky_lux: DVec3,
    /// Mean of the horizon without the glow around the sun.
    pub horizon: DVec3,
}

impl Dome {
    /// The sky for sunlight that travels against the unit direction `to_sun`.
    #[must_use]
    pub fn new(atmosphere: &Atmosphere, to_sun: DVec3) -> Self {
        let (sin, cos) = to_sun.y.clamp(-1.0, 1.0).asin().sin_cos();
        let table = (0..ROWS * COLUMNS)
            .map(|i| {
                let elevation = FRAC_PI_2 * ((i / COLUMNS) as f64 / (ROWS - 1) as f64).powi(2);
                let azimuth = PI * (i % COLUMNS) as f64 / (COLUMNS - 1) as f64;
                let view = DVec3::new(
                    azimuth.cos() * elevation.cos(),
                    elevation.sin(),
                    azimuth.sin() * elevation.cos(),
                );
                atmosphere.inscattering(EYE, view, DVec3::new(cos, sin, 0.0))
            })
            .collect();
        let mut dome = Self {
            to_sun,
            table,
            sun_lux: SUN_LUX * atmosphere.transmittance(GROUND_RADIUS + EYE, to_sun.y),
            sky_lux: DVec3::ZERO,
            horizon: DVec3::ZERO,
        };
        dome.sky_lux = (0..DIRECTIONS)
            .map(|i| atmosphere::sphere_direction(i, DIRECTIONS))
            .filter(|direction| direction.y > 0.0)
            .fold(DVec3::ZERO, |sum, direction| sum + dome.sky(direction) * direction.y)
            * (4.0 * PI / DIRECTIONS as f64);
        // Aside from the sun: half way between its azimuth and the one across.
        let aside = dome.inscattering(0.03, FRAC_PI_2);
        dome.horizon = SUN_LUX * (aside.rayleigh * rayleigh_phase(0.0) + aside.mie * mie_phase(0.0) + aside.multiple);
        dome
    }

    /// Radiance of the sky in a unit direction, without the sun itself; below the horizon that of the horizon.
    #[must_use]
    pub fn sky(&self, view: DVec3) -> DVec3 {
        let elevation = view.y.clamp(0.0, 1.0).asin();
        let across = |direction: DVec3| DVec3::new(direction.x, 0.0, direction.z).normalize_or_zero();
        let azimuth = across(view).dot(across(self.to_sun)).clamp(-1.0, 1.0).acos();
        let light = self.inscattering(elevation, azimuth);
        let cos = DVec3::new(view.x, view.y.max(0.0), view.z)
            .normalize_or(DVec3::Y)
            .dot(self.to_sun);
        SUN_LUX * (light.rayleigh * rayleigh_phase(cos) + light.mie * mie_phase(cos) + light.multiple)
    }

    /// What lights a thing from a unit direction: the sky above, lit ground below.
    #[must_use]
    pub fn surroundings(&self, view: DVec3) -> DVec3 {
        if view.y > 0.0 {
            self.sky(view)
        } else {
            GROUND_ALBEDO / PI * (self.sky_lux + SUNLIT_GROUND * self.sun_lux * self.to_sun.y.max(0.0))
        }
    }

    /// The sky as a camera shows it: exposed, tone-mapped, with the sun's disc. Linear RGB, 0..=1.
    #[must_use]
    pub fn seen(&self, view: DVec3, exposure: f64) -> DVec3 {
        let sky = self.sky(view);
        let angle = view.dot(self.to_sun).clamp(-1.0, 1.0).acos();
        let share = atmosphere::smooth((DISC[1] - angle) / (DISC[1] - DISC[0])) * f64::from(view.y > 0.0);
        let disc = self.sun_lux / (PI * DISC[1] * DISC[1]);
        aces_fitted((sky + share * disc) * exposure)
    }

    /// Mean radiance that a surface with this normal receives: its illuminance over π.
    #[must_use]
    pub fn received(&self, lights: &[(DVec3, DVec3)], normal: DVec3) -> DVec3 {
        let facing = |direction: DVec3| direction.dot(normal).max(0.0);
        let total: f64 = lights.iter().map(|(direction, _)| facing(*direction)).sum();
        let sum = lights
            .iter()
            .fold(DVec3::ZERO, |sum, (direction, light)| sum + *light * facing(*direction));
        sum / total.max(1e-9)
    }

    /// The surroundings in directions spread evenly over the sphere, for [`Self::received`].
    #[must_use]
    pub fn lights(&self) -> Vec<(DVec3, DVec3)> {
        (0..DIRECTIONS)
            .map(|i| atmosphere::sphere_direction(i, DIRECTIONS))
            .map(|direction| (direction, self.surroundings(direction)))
            .collect()
    }

    fn inscattering(&self, elevation: f64, azimuth: f64) -> Inscattering {
        let row = (elevation / FRAC_PI_2).max(0.0).sqrt() * (ROWS - 1) as f64;
        let column = azimuth / PI * (COLUMNS - 1) as f64;
        let (y, x) = ((row as usize).min(ROWS - 2), (column as usize).min(COLUMNS - 2));
        let (t, s) = (row - y as f64, column - x as f64);
        let at = |x: usize, y: usize| self.table[y * COLUMNS + x];
        let weigh = |pick: fn(Inscattering) -> DVec3| {
            let line = |y: usize| pick(at(x, y)).lerp(pick(at(x + 1, y)), s);
            line(y).lerp(line(y + 1), t)
        };
        Inscattering {
            rayleigh: weigh(|light| light.rayleigh),
            mie: weigh(|light| light.mie),
            multiple: weigh(|light| light.multiple),
        }
    }
}

/// Unit directions of the texels of a cube map with faces of `side` texels, in the order of its bytes: right, left, up,
/// down, towards −z, towards +z, each from its top row down. Bevy samples cube maps with z turned round.
pub fn cube_directions(side: u32) -> impl Iterator<Item = DVec3> {
    let at = move |i: u32| 2.0 * (f64::from(i) + 0.5) / f64::from(side) - 1.0;
    (0..6 * side * side).map(move |i| {
        let (u, v) = (at(i % side), at(i / side % side));
        let left_handed = match i / (side * side) {
            0 => DVec3::new(1.0, -v, -u),
            1 => DVec3::new(-1.0, -v, u),
            2 => DVec3::new(u, 1.0, v),
            3 => DVec3::new(u, -1.0, -v),
            4 => DVec3::new(u, -v, 1.0),
            _ => DVec3::new(-u, -v, -1.0),
        };
        (left_handed * DVec3::new(1.0, 1.0, -1.0)).normalize()
    })
}

/// RGBA bytes in sRGB of a linear colour in 0..=1.
#[must_use]
pub fn srgb_bytes(linear: DVec3) -> [u8; 4] {
    let encode = |value: f64| {
        let value = value.clamp(0.0, 1.0);
        let encoded = if value <= 0.003_130_8 {
            12.92 * value
        } else {
            1.055 * value.powf(1.0 / 2.4) - 0.055
        };
        (encoded * 255.0).round() as u8
    };
    [encode(linear.x), encode(linear.y), encode(linear.z), 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dome(elevation_deg: f64) -> Dome {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        Dome::new(&Atmosphere::new(0.1), DVec3::new(0.6 * cos, sin, -0.8 * cos))
    }

    /// Tables of daylight (CIE clear skies): a high sun gives about 100,000 lux, the clear sky 10,000 to 20,000; at 10
    /// degrees the sun still gives tens of thousands, and redder.
    #[test]
    fn daylight_has_the_illuminances_of_daylight_tables() {
        let noon = dome(65.0);
        let sun = noon.sun_lux.dot(LUMA);
        assert!((90_000.0..110_000.0).contains(&sun), "{sun}");
        let sky = noon.sky_lux.dot(LUMA);
        assert!((8_000.0..22_000.0).contains(&sky), "{sky}");
        let low = dome(10.0);
        let sun_low = low.sun_lux.dot(LUMA);
        assert!((25_000.0..65_000.0).contains(&sun_low), "{sun_low}");
        assert!(low.sun_lux.x > 1.3 * low.sun_lux.z, "{}", low.sun_lux);
        assert_eq!(dome(-5.0).sun_lux, DVec3::ZERO);
    }

    #[test]
    fn the_sun_is_the_brightest_place_and_the_sky_is_smooth() {
        let dome = dome(20.0);
        let exposure = 1e-5;
        let brightest = cube_directions(32).max_by(|a, b| {
            let luma = |view: &DVec3| dome.sky(*view).dot(LUMA);
            luma(a).total_cmp(&luma(b))
        });
        assert!(brightest.expect("texels").dot(dome.to_sun) > 0.99, "{brightest:?}");
        assert!(dome.seen(dome.to_sun, exposure).min_element() > 0.9, "the disc");
        let around = |azimuth: f64| {
            dome.sky(DVec3::new(azimuth.sin() * 0.9, 0.43589, -azimuth.cos() * 0.9))
                .dot(LUMA)
        };
        for degrees in 0..360 {
            let (a, b) = (
                around(f64::from(degrees).to_radians()),
                around(f64::from(degrees + 1).to_radians()),
            );
            assert!((a - b).abs() < 0.12 * a, "{degrees}: {a} {b}");
        }
    }

    #[test]
    fn surfaces_receive_what_is_before_them() {
        let dome = dome(50.0);
        let lights = dome.lights();
        let up = dome.received(&lights, DVec3::Y);
        assert!(
            (up * PI).abs_diff_eq(dome.sky_lux, 0.03 * dome.sky_lux.y),
            "{up}, {}",
            dome.sky_lux
        );
        assert!(up.z > up.x, "blue from above: {up}");
        let down = dome.received(&lights, DVec3::NEG_Y);
        assert!(down.x > down.z, "brown from below: {down}");
    }

    #[test]
    fn cube_maps_have_bevys_order() {
        let directions: Vec<DVec3> = cube_directions(3).collect();
        let middles = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::NEG_Z, DVec3::Z];
        for (face, middle) in middles.into_iter().enumerate() {
            assert!(directions[face * 9 + 4].abs_diff_eq(middle, 1e-9), "face {face}");
        }
        let upper_row = &directions[..3];
        assert!(upper_row.iter().all(|direction| direction.y > 0.4), "rows begin on top");
    }

    #[test]
    fn colours_are_encoded_as_srgb() {
        assert_eq!(srgb_bytes(DVec3::new(0.0, 0.215_861, 1.0)), [0, 128, 255, 255]);
        assert_eq!(srgb_bytes(DVec3::new(-1.0, 0.002, 7.0)), [0, 7, 255, 255]);
    }
}
