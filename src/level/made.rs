//! [`Made`]: what people put up in city and forest, and which model files it is drawn with.

use bevy_math::{Vec2, Vec3};

use super::model::{AssetRef, Tint};

/// Something made, at its own size: feet on the ground, +y up, fronts look along +z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Made {
    /// A mast of 6.5 m whose arm reaches along +x.
    Lamp,
    /// A cast-iron lamp of 4.6 m.
    OldLamp,
    /// A traffic light.
    TrafficLight,
    /// A sign: no parking.
    NoParking,
    /// A sign: priority road.
    Priority,
    /// A sign: pedestrian crossing.
    Crossing,
    /// A sign: tram stop.
    TramStop,
    /// Two street names on a post.
    StreetName,
    /// A pole whose bracket holds the tram's wire 4 m along +x.
    WirePole,
    /// A bench, 1.8 m along x.
    Bench,
    /// A litter bin.
    Bin,
    /// A bollard.
    Bollard,
    /// A post box.
    PostBox,
    /// A newspaper kiosk.
    Kiosk,
    /// A café table with three chairs.
    Cafe,
    /// A parasol; its cloth takes the tint.
    Parasol,
    /// A bicycle in a stand, along z; its frame takes the tint.
    Bicycle,
    /// A grate around a street tree.
    Grate,
    /// A planter of 60 cm.
    Pot,
    /// A panel of a railing: 2 m along +x.
    Railing,
    /// A shelter at a tram stop.
    Shelter,
    /// A small car; its body takes the tint.
    Hatchback,
    /// A longer car.
    Estate,
    /// A small lorry; its cab takes the tint.
    Lorry,
    /// A tram of two cars along z; its sides take the tint.
    Tram,
    /// A fountain in a basin of 7 m.
    Fountain,
    /// The lattice tower, [`TOWER_HEIGHT`] high.
    Tower,
    /// A log cabin.
    Hut,
    /// A fence post of 1 m.
    SplitPost,
    /// Three split rails of 1 m along +x, for a fence of 1 m.
    SplitRails,
}

/// Height of the tower's model in metres.
pub const TOWER_HEIGHT: f32 = 118.0;
/// Middle and half the side of the tower's feet, in metres from its axis, the same along x and z.
pub const TOWER_FEET: (f32, f32) = (9.5, 3.1);
/// Where a wire pole holds the wire: along +x, and up.
pub const WIRE_HOLD: Vec2 = Vec2::new(4.0, 5.6);

/// What a walker bumps into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Foot {
    /// Nothing.
    Free,
    /// An upright cylinder of this radius in metres.
    Round(f32),
    /// A box around the origin: half its sides along x and z in metres.
    Box(f32, f32),
    /// A thin wall of this length along +x from the origin, in metres.
    Wall(f32),
}

impl Made {
    /// File, variant, height in metres, what a walker bumps into.
    fn facts(self) -> (&'static str, u32, f32, Foot) {
        match self {
            Self::Lamp => ("street", 0, 6.5, Foot::Round(0.13)),
            Self::OldLamp => ("street", 1, 4.6, Foot::Round(0.18)),
            Self::TrafficLight => ("street", 2, 3.4, Foot::Round(0.1)),
            Self::NoParking => ("street", 3, 2.6, Foot::Round(0.05)),
            Self::Priority => ("street", 4, 2.6, Foot::Round(0.05)),
            Self::Crossing => ("street", 5, 2.6, Foot::Round(0.05)),
            Self::TramStop => ("street", 6, 2.6, Foot::Round(0.05)),
            Self::StreetName => ("street", 7, 3.1, Foot::Round(0.05)),
            Self::WirePole => ("street", 8, 7.2, Foot::Round(0.15)),
            Self::Bench => ("street", 9, 0.9, Foot::Box(0.9, 0.35)),
            Self::Bin => ("street", 10, 0.95, Foot::Round(0.26)),
            Self::Bollard => ("street", 11, 0.95, Foot::Round(0.1)),
            Self::PostBox => ("street", 12, 1.45, Foot::Box(0.27, 0.22)),
            Self::Kiosk => ("street", 13, 3.3, Foot::Box(1.65, 1.3)),
            Self::Cafe => ("street", 14, 0.9, Foot::Round(0.75)),
            Self::Parasol => ("street", 15, 2.6, Foot::Round(0.1)),
            Self::Bicycle => ("street", 16, 1.0, Foot::Box(0.25, 0.85)),
            Self::Grate => ("street", 17, 0.03, Foot::Free),
            Self::Pot => ("street", 18, 0.6, Foot::Round(0.43)),
            Self::Railing => ("street", 19, 1.2, Foot::Wall(2.0)),
            Self::Shelter => ("street", 20, 2.75, Foot::Box(2.05, 0.75)),
            Self::Hatchback => ("cars", 0, 1.48, Foot::Box(0.88, 2.06)),
            Self::Estate => ("cars", 1, 1.48, Foot::Box(0.91, 2.36)),
            Self::Lorry => ("cars", 2, 2.97, Foot::Box(1.06, 3.02)),
            Self::Tram => ("tram", 0, 5.6, Foot::Box(1.25, 11.25)),
            Self::Fountain => ("fountain", 0, 4.3, Foot::Round(4.3)),
            // A walker passes between the legs.
            Self::Tower => ("tower", 0, TOWER_HEIGHT, Foot::Free),
            Self::Hut => ("cabin", 0, 5.9, Foot::Box(3.2, 2.6)),
            Self::SplitPost => ("cabin", 1, 1.0, Foot::Round(0.1)),
            Self::SplitRails => ("cabin", 2, 0.95, Foot::Wall(1.0)),
        }
    }

    /// The file and the variant that it is drawn with.
    pub fn asset(self) -> AssetRef {
        let (file, variant, ..) = self.facts();
        AssetRef { file, variant }
    }

    /// Metres, at scale 1.
    pub fn height(self) -> f32 {
        self.facts().2
    }

    /// What a walker bumps into, at scale 1.
    pub fn foot(self) -> Foot {
        self.facts().3
    }

    /// Half the extent of a box that may stand in for its file, at scale 1.
    pub fn half_extent(self) -> Vec3 {
        let (.., height, foot) = self.facts();
        let (x, z) = match foot {
            Foot::Free => (0.1 * height, 0.1 * height),
            Foot::Round(radius) => (radius, radius),
            Foot::Box(x, z) => (x, z),
            Foot::Wall(length) => (0.5 * length, 0.05),
        };
        Vec3::new(x, 0.5 * height, z)
    }
}

/// Paints of cars: white, silver, grey, black, and a few colours; sRGB.
pub const CAR_PAINTS: [Tint; 9] = [
    Tint([236, 236, 232]),
    Tint([176, 180, 184]),
    Tint([112, 116, 122]),
    Tint([44, 46, 50]),
    Tint([30, 44, 92]),
    Tint([150, 28, 30]),
    Tint([36, 78, 70]),
    Tint([196, 172, 120]),
    Tint([70, 118, 168]),
];

/// Cloth of parasols.
pub const CLOTHS: [Tint; 3] = [Tint([238, 226, 196]), Tint([190, 60, 48]), Tint([72, 116, 92])];

/// Frames of bicycles.
pub const FRAMES: [Tint; 4] = [
    Tint([40, 42, 46]),
    Tint([52, 96, 140]),
    Tint([168, 52, 44]),
    Tint([214, 206, 188]),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forge;

    const NAMES: [(Made, &str); 30] = [
        (Made::Lamp, "lamp"),
        (Made::OldLamp, "lamp_old"),
        (Made::TrafficLight, "traffic_light"),
        (Made::NoParking, "sign_no_parking"),
        (Made::Priority, "sign_priority"),
        (Made::Crossing, "sign_crossing"),
        (Made::TramStop, "sign_stop"),
        (Made::StreetName, "street_name"),
        (Made::WirePole, "wire_pole"),
        (Made::Bench, "bench"),
        (Made::Bin, "bin"),
        (Made::Bollard, "bollard"),
        (Made::PostBox, "post_box"),
        (Made::Kiosk, "kiosk"),
        (Made::Cafe, "cafe"),
        (Made::Parasol, "parasol"),
        (Made::Bicycle, "bicycle"),
        (Made::Grate, "grate"),
        (Made::Pot, "pot"),
        (Made::Railing, "railing"),
        (Made::Shelter, "shelter"),
        (Made::Hatchback, "hatchback"),
        (Made::Estate, "estate"),
        (Made::Lorry, "lorry"),
        (Made::Tram, "tram"),
        (Made::Fountain, "fountain"),
        (Made::Tower, "tower"),
        (Made::Hut, "hut"),
        (Made::SplitPost, "fence_post"),
        (Made::SplitRails, "fence_rails"),
    ];

    #[test]
    fn files_have_the_named_variants_of_the_right_size() {
        for (made, name) in NAMES {
            let asset = made.asset();
            let recipe = forge::assets().iter().find(|recipe| recipe.name == asset.file);
            let model = recipe.expect("a recipe").model();
            let variant = &model.variants[asset.variant as usize];
            assert_eq!(variant.name, name);
            let (low, high) = variant.lods[0].bounds().expect("vertices");
            assert!((high.y - made.height()).abs() < 0.15, "{name} is {} m high", high.y);
            let reach = match made.foot() {
                Foot::Box(x, z) => Vec2::new(x, z),
                Foot::Wall(length) => {
                    assert!((high.x - length).abs() < 0.05, "{name} is {} m long", high.x);
                    continue;
                }
                Foot::Round(_) | Foot::Free => continue,
            };
            let half = 0.5 * (high - low);
            // Mirrors, eaves, awnings and porches stick out over what stops a walker.
            assert!(
                reach.x < half.x + 0.1 && reach.y < half.z + 0.1 && half.x < reach.x + 0.6,
                "{name}: {half} around {reach}"
            );
        }
    }
}
