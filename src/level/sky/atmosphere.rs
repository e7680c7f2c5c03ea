//! How sunlight comes through the air: transmittance, single scattering and an approximation of all further scattering.
//!
//! S. Hillaire, "A Scalable and Production Ready Sky and Atmosphere Rendering Technique", EGSR 2020, on the processor:
//! density profiles and coefficients of its table 1, the transmittance table of E. Bruneton, "Precomputed Atmospheric
//! Scattering" (2017 implementation), multiple scattering by equations 5 to 10. Aerosols are given by their optical
//! depth, as weather stations measure it. Lengths are kilometres, as altitudes need them; spectra are linear RGB.

use std::f64::consts::PI;

use bevy::math::{DVec2, DVec3};

/// The planet's radius.
pub const GROUND_RADIUS: f64 = 6360.0;
/// Where the air ends.
const TOP_RADIUS: f64 = 6460.0;
/// Scale heights of air molecules and aerosols.
const RAYLEIGH_HEIGHT: f64 = 8.0;
const MIE_HEIGHT: f64 = 1.2;
/// Scattering of air molecules on the ground, per kilometre.
const RAYLEIGH: DVec3 = DVec3::new(5.802e-3, 13.558e-3, 33.1e-3);
/// Absorption of ozone at the altitude where it is densest, per kilometre.
const OZONE: DVec3 = DVec3::new(0.650e-3, 1.881e-3, 0.085e-3);
const OZONE_ALTITUDE: f64 = 25.0;
const OZONE_HALF_WIDTH: f64 = 15.0;
/// Share of the light that aerosols meet which they scatter (Bruneton 2017).
const MIE_ALBEDO: f64 = 0.9;
/// Aerosols' extinction at 680, 550 and 440 nm over that at 550 nm, with A. Ångström's exponent of 1.3 (1929).
const MIE_SPECTRUM: DVec3 = DVec3::new(0.759, 1.0, 1.337);
/// Asymmetry of aerosol scattering in the function of Henyey and Greenstein.
const MIE_ASYMMETRY: f64 = 0.78;
/// Reflectance of the ground seen from far above: of forests and towns.
const GROUND_ALBEDO: f64 = 0.2;
/// Half of the angle under which the sun is seen, in radians.
pub const SUN_RADIUS: f64 = 0.004_65;

/// Columns (directions) and rows (altitudes) of the transmittance table.
const TRANSMITTANCE_SIZE: [usize; 2] = [64, 24];
const TRANSMITTANCE_STEPS: usize = 40;
/// Columns (heights of the sun) and rows (altitudes) of the multiple scattering table.
const SCATTERING_SIZE: [usize; 2] = [24, 8];
const SCATTERING_DIRECTIONS: usize = 32;
const SCATTERING_STEPS: usize = 16;
/// Steps along a view ray.
const VIEW_STEPS: usize = 32;

/// Air over a planet, with the tables that depend on nothing else.
#[derive(Clone, Debug)]
pub struct Atmosphere {
    mie_extinction: DVec3,
    transmittance: Table,
    scattering: Table,
}

/// Light that comes in along a ray for one unit of sunlight above the air, without the phase functions: multiply each
/// by its own. Linear RGB, per steradian.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inscattering {
    /// Scattered once by air: times [`rayleigh_phase`].
    pub rayleigh: DVec3,
    /// Scattered once by aerosols: times [`mie_phase`].
    pub mie: DVec3,
    /// Scattered more than once, alike from everywhere.
    pub multiple: DVec3,
}

/// What the air does at one altitude, per kilometre.
struct Local {
    rayleigh: DVec3,
    mie: DVec3,
    extinction: DVec3,
}

/// Values on a lattice over the unit square.
#[derive(Clone, Debug)]
struct Table {
    size: [usize; 2],
    values: Vec<DVec3>,
}

impl Table {
    fn new(size: [usize; 2], value: impl Fn(DVec2) -> DVec3) -> Self {
        let share = |i: usize, count: usize| i as f64 / (count - 1) as f64;
        let at = |i: usize| DVec2::new(share(i % size[0], size[0]), share(i / size[0], size[1]));
        Self {
            size,
            values: (0..size[0] * size[1]).map(|i| value(at(i))).collect(),
        }
    }

    fn sample(&self, uv: DVec2) -> DVec3 {
        let [columns, rows] = self.size;
        let at = uv.clamp(DVec2::ZERO, DVec2::ONE) * DVec2::new((columns - 1) as f64, (rows - 1) as f64);
        let (x, y) = ((at.x as usize).min(columns - 2), (at.y as usize).min(rows - 2));
        let (s, t) = (at.x - x as f64, at.y - y as f64);
        let row = |y: usize| self.values[y * columns + x].lerp(self.values[y * columns + x + 1], s);
        row(y).lerp(row(y + 1), t)
    }
}

/// Share of scattered light per steradian at an angle of this cosine, for air molecules.
#[must_use]
pub fn rayleigh_phase(cos: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cos * cos)
}

/// The same for aerosols (Henyey and Greenstein 1941).
#[must_use]
pub fn mie_phase(cos: f64) -> f64 {
    let g = MIE_ASYMMETRY;
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5))
}

/// Length of a ray from radius `r` under the zenith cosine `mu` to the sphere of radius `sphere` from within.
fn distance_to(sphere: f64, r: f64, mu: f64) -> f64 {
    -r * mu + (r * r * (mu * mu - 1.0) + sphere * sphere).max(0.0).sqrt()
}

/// Length of such a ray to the ground, where it meets it.
fn distance_to_ground(r: f64, mu: f64) -> Option<f64> {
    let under_root = r * r * (mu * mu - 1.0) + GROUND_RADIUS * GROUND_RADIUS;
    (mu < 0.0 && under_root >= 0.0).then(|| (-r * mu - under_root.sqrt()).max(0.0))
}

impl Atmosphere {
    /// Air with aerosols of this optical depth straight up: 0.02 over mountains, 0.1 on a clear day in the lowlands,
    /// 0.4 in haze.
    #[must_use]
    pub fn new(aerosol_depth: f64) -> Self {
        let empty = Table {
            size: [2, 2],
            values: vec![DVec3::ZERO; 4],
        };
        let mut atmosphere = Self {
            mie_extinction: aerosol_depth / MIE_HEIGHT * MIE_SPECTRUM,
            transmittance: empty.clone(),
            scattering: empty,
        };
        atmosphere.transmittance = Table::new(TRANSMITTANCE_SIZE, |uv| {
            let (r, mu) = transmittance_ray(uv);
            atmosphere.integrate_transmittance(r, mu)
        });
        atmosphere.scattering = Table::new(SCATTERING_SIZE, |uv| {
            let r = GROUND_RADIUS + 0.01 + uv.y * (TOP_RADIUS - GROUND_RADIUS - 0.02);
            atmosphere.integrate_scattering(r, 2.0 * uv.x - 1.0)
        });
        atmosphere
    }

    /// Share of light that arrives at radius `r` from outside the air, from the zenith cosine `mu`; 0 where the planet
    /// is in the way. The planet's edge is as soft as the sun is wide.
    #[must_use]
    pub fn transmittance(&self, r: f64, mu: f64) -> DVec3 {
        let horizon = -(1.0 - (GROUND_RADIUS / r).powi(2)).max(0.0).sqrt();
        let visible = smooth((mu - horizon) / SUN_RADIUS * 0.5 + 0.5);
        let d_min = TOP_RADIUS - r;
        let d_max = height_over_horizon(r) + height_over_horizon(TOP_RADIUS);
        let d = distance_to(TOP_RADIUS, r, mu.max(horizon));
        let uv = DVec2::new(
            (d - d_min) / (d_max - d_min),
            height_over_horizon(r) / height_over_horizon(TOP_RADIUS),
        );
        self.transmittance.sample(uv) * visible
    }

    /// What comes in from the unit direction `view` to an eye at `altitude` when the sun is in the unit direction
    /// `to_sun`; y is up. Rays that meet the ground end there.
    #[must_use]
    pub fn inscattering(&self, altitude: f64, view: DVec3, to_sun: DVec3) -> Inscattering {
        let r = GROUND_RADIUS + altitude.max(0.001);
        let length = distance_to_ground(r, view.y).unwrap_or_else(|| distance_to(TOP_RADIUS, r, view.y));
        let mut total = Inscattering::default();
        let mut through = DVec3::ONE;
        let mut last = 0.0;
        for i in 1..=VIEW_STEPS {
            // Denser near the eye, where the air is.
            let end = length * (i as f64 / VIEW_STEPS as f64).powi(2);
            let step = end - last;
            let at = DVec3::Y * r + view * (0.5 * (last + end));
            last = end;
            let (radius, local) = self.local(at);
            let mu = at.dot(to_sun) / radius;
            let light = self.transmittance(radius, mu);
            let multiple = self.multiple(radius, mu) * (local.rayleigh + local.mie);
            let (weight, passed) = step_weight(local.extinction, step, through);
            total.rayleigh += weight * light * local.rayleigh;
            total.mie += weight * light * local.mie;
            total.multiple += weight * multiple;
            through = passed;
        }
        total
    }

    fn local(&self, at: DVec3) -> (f64, Local) {
        let radius = at.length();
        let altitude = (radius - GROUND_RADIUS).max(0.0);
        let rayleigh = RAYLEIGH * (-altitude / RAYLEIGH_HEIGHT).exp();
        let mie = self.mie_extinction * (-altitude / MIE_HEIGHT).exp();
        let ozone = OZONE * (1.0 - (altitude - OZONE_ALTITUDE).abs() / OZONE_HALF_WIDTH).max(0.0);
        let local = Local {
            rayleigh,
            mie: MIE_ALBEDO * mie,
            extinction: rayleigh + mie + ozone,
        };
        (radius, local)
    }

    fn integrate_transmittance(&self, r: f64, mu: f64) -> DVec3 {
        let length = distance_to(TOP_RADIUS, r, mu);
        let direction = DVec3::new((1.0 - mu * mu).max(0.0).sqrt(), mu, 0.0);
        // Denser at the beginning, which is near the ground where it matters.
        let end = |i: usize| length * (i as f64 / TRANSMITTANCE_STEPS as f64).powi(2);
        let depth = (0..TRANSMITTANCE_STEPS).fold(DVec3::ZERO, |depth, i| {
            let at = DVec3::Y * r + direction * (0.5 * (end(i) + end(i + 1)));
            depth + self.local(at).1.extinction * (end(i + 1) - end(i))
        });
        (-depth).exp()
    }

    /// Hillaire's multiple scattering: light scattered twice, alike in all directions, and the share of it that every
    /// further scattering hands on.
    fn integrate_scattering(&self, r: f64, mu_sun: f64) -> DVec3 {
        let to_sun = DVec3::new((1.0 - mu_sun * mu_sun).max(0.0).sqrt(), mu_sun, 0.0);
        let mut second = DVec3::ZERO;
        let mut handed_on = DVec3::ZERO;
        for i in 0..SCATTERING_DIRECTIONS {
            let view = sphere_direction(i, SCATTERING_DIRECTIONS);
            let ground = distance_to_ground(r, view.y);
            let step = ground.unwrap_or_else(|| distance_to(TOP_RADIUS, r, view.y)) / SCATTERING_STEPS as f64;
            let mut through = DVec3::ONE;
            for j in 0..SCATTERING_STEPS {
                let at = DVec3::Y * r + view * ((j as f64 + 0.5) * step);
                let (radius, local) = self.local(at);
                let scattering = local.rayleigh + local.mie;
                let light = self.transmittance(radius, at.dot(to_sun) / radius);
                let (weight, passed) = step_weight(local.extinction, step, through);
                second += weight * scattering * light / (4.0 * PI);
                handed_on += weight * scattering;
                through = passed;
            }
            if let Some(length) = ground {
                let up = (DVec3::Y * r + view * length).normalize();
                let mu = up.dot(to_sun);
                let light = self.transmittance(GROUND_RADIUS + 0.001, mu) * mu.max(0.0);
                second += through * light * GROUND_ALBEDO / PI;
            }
        }
        let directions = SCATTERING_DIRECTIONS as f64;
        (second / directions) / (DVec3::ONE - handed_on / directions)
    }

    /// Light scattered more than once, per unit of scattering.
    fn multiple(&self, r: f64, mu_sun: f64) -> DVec3 {
        let altitude = (r - GROUND_RADIUS) / (TOP_RADIUS - GROUND_RADIUS);
        self.scattering.sample(DVec2::new(0.5 * mu_sun + 0.5, altitude))
    }
}

/// How much one step adds per unit of what is scattered in it, with the exact integral over the step, and what passes
/// to the next one (Hillaire 2015, "Physically based and unified volumetric rendering in Frostbite").
fn step_weight(extinction: DVec3, step: f64, through: DVec3) -> (DVec3, DVec3) {
    let passed = through * (-extinction * step).exp();
    ((through - passed) / extinction.max(DVec3::splat(1e-12)), passed)
}

/// Length of a tangent from radius `r` to the ground.
fn height_over_horizon(r: f64) -> f64 {
    (r * r - GROUND_RADIUS * GROUND_RADIUS).max(0.0).sqrt()
}

/// The ray of a place in the transmittance table (Bruneton 2017).
fn transmittance_ray(uv: DVec2) -> (f64, f64) {
    let horizon_top = height_over_horizon(TOP_RADIUS);
    let rho = horizon_top * uv.y;
    let r = (rho * rho + GROUND_RADIUS * GROUND_RADIUS).sqrt();
    let d_min = TOP_RADIUS - r;
    let d = d_min + uv.x * (rho + horizon_top - d_min);
    let mu = if d <= 0.0 {
        1.0
    } else {
        (horizon_top * horizon_top - rho * rho - d * d) / (2.0 * r * d)
    };
    (r, mu.clamp(-1.0, 1.0))
}

/// Directions spread evenly over the sphere (Fibonacci lattice).
pub(super) fn sphere_direction(i: usize, count: usize) -> DVec3 {
    let y = 1.0 - (2 * i + 1) as f64 / count as f64;
    let turn = i as f64 * PI * (3.0 - 5f64.sqrt());
    let radius = (1.0 - y * y).sqrt();
    DVec3::new(radius * turn.cos(), y, radius * turn.sin())
}

/// From 0 to 1 without corners.
pub(super) fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LUMA: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

    fn clear() -> Atmosphere {
        Atmosphere::new(0.1)
    }

    /// Straight up the depths are 8 km of air, the aerosols' own, and 15 km of ozone (a triangle 30 km wide): red
    /// 0.0464 + 0.0759 + 0.0098, green 0.1085 + 0.1 + 0.0282, blue 0.2648 + 0.1337 + 0.0013.
    #[test]
    fn the_zenith_lets_through_what_the_coefficients_say() {
        let expected = DVec3::new(0.1321, 0.2367, 0.3998);
        let found = clear().transmittance(GROUND_RADIUS, 1.0);
        assert!((-found.map(f64::ln)).abs_diff_eq(expected, 0.003), "{found}");
    }

    #[test]
    fn the_table_holds_what_was_integrated() {
        let air = clear();
        for (altitude, mu) in [(0.0, 0.5), (0.5, 0.12), (3.0, 0.03), (20.0, 0.9)] {
            let r = GROUND_RADIUS + altitude;
            let (table, exact) = (air.transmittance(r, mu), air.integrate_transmittance(r, mu));
            assert!(
                table.abs_diff_eq(exact, 0.02),
                "{altitude} km, {mu}: {table} for {exact}"
            );
        }
    }

    #[test]
    fn the_lower_the_sun_the_weaker_and_the_redder() {
        let air = clear();
        let through =
            [90.0f64, 30.0, 10.0, 3.0].map(|degrees| air.transmittance(GROUND_RADIUS, degrees.to_radians().sin()));
        for pair in through.windows(2) {
            assert!(pair[1].dot(LUMA) < pair[0].dot(LUMA), "{pair:?}");
            assert!(pair[1].x / pair[1].z > pair[0].x / pair[0].z, "{pair:?}");
        }
        assert_eq!(air.transmittance(GROUND_RADIUS, -0.1), DVec3::ZERO, "below the horizon");
    }

    #[test]
    fn phase_functions_share_out_all_light() {
        for phase in [rayleigh_phase, mie_phase] {
            let count = 20_000;
            let sum: f64 = (0..count).map(|i| phase(sphere_direction(i, count).y)).sum();
            let integral = sum * 4.0 * PI / count as f64;
            assert!((integral - 1.0).abs() < 1e-3, "{integral}");
        }
    }

    /// Colours and luminance of a clear summer sky.
    #[test]
    fn the_day_sky_is_blue_above_and_pale_at_the_horizon() {
        let air = clear();
        let to_sun = DVec3::new(0.6, 0.8, 0.0);
        let seen = |view: DVec3| {
            let light = air.inscattering(0.0, view.normalize(), to_sun);
            let cos = view.normalize().dot(to_sun);
            light.rayleigh * rayleigh_phase(cos) + light.mie * mie_phase(cos) + light.multiple
        };
        let (zenith, horizon) = (seen(DVec3::Y), seen(DVec3::new(-1.0, 0.02, 0.3)));
        assert!(zenith.z > 1.8 * zenith.x, "blue: {zenith}");
        assert!(
            horizon.z / horizon.x < 0.8 * zenith.z / zenith.x,
            "paler: {horizon}, {zenith}"
        );
        assert!(horizon.dot(LUMA) > zenith.dot(LUMA), "brighter: {horizon}, {zenith}");
        // Clear skies measure 2,000 to 6,000 candela per square metre overhead under 128,000 lux outside the air.
        let luminance = 128_000.0 * zenith.dot(LUMA);
        assert!((1_500.0..7_000.0).contains(&luminance), "{luminance}");
    }

    #[test]
    fn after_sunset_the_sky_still_glows_and_at_night_it_is_dark() {
        let air = clear();
        let glow = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let light = air.inscattering(0.0, DVec3::new(0.5, 0.5, 0.0).normalize(), DVec3::new(cos, sin, 0.0));
            (light.rayleigh + light.mie + light.multiple).dot(LUMA)
        };
        assert!(
            glow(-3.0) > 1e-4 && glow(-3.0) < glow(3.0),
            "{} {}",
            glow(-3.0),
            glow(3.0)
        );
        assert!(glow(-20.0) < 1e-6, "{}", glow(-20.0));
    }
}
