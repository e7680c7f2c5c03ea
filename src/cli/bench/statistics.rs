//! Statistics of measured times: numbers in, numbers out.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// Share of frames that the "1 % low" speaks of.
const SLOWEST_SHARE: f64 = 0.01;
/// Resamples behind an interval.
const RESAMPLES: usize = 1000;
/// The interval holds this share of the resamples.
const CONFIDENCE: f64 = 0.95;

/// The value below which a share of the values lies, linear between neighbours; 0 for none.
pub(super) fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else {
        return 0.0;
    };
    let place = share.clamp(0.0, 1.0) * last as f64;
    let (below, above) = (place.floor() as usize, place.ceil() as usize);
    sorted[below] + (sorted[above] - sorted[below]) * (place - place.floor())
}

/// The middle value, or the mean of the middle two; 0 for none.
pub(super) fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// The mean of the slowest hundredth of frame times, of one frame at least; 0 for none.
pub(super) fn low_1_percent(times: &[f64]) -> f64 {
    let mut slowest_first = times.to_vec();
    slowest_first.sort_by(|a, b| b.total_cmp(a));
    let count = (times.len() as f64 * SLOWEST_SHARE).ceil() as usize;
    slowest_first.truncate(count);
    slowest_first.iter().sum::<f64>() / slowest_first.len().max(1) as f64
}

/// How much longer one thing takes than another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Ratio {
    /// Median over median.
    pub(super) of_medians: f64,
    /// Where the 95 % interval of the ratio begins.
    pub(super) low: f64,
    /// Where it ends.
    pub(super) high: f64,
}

/// The ratio of medians of times of the same frames, with its bootstrap percentile interval (Efron 1979): frames are
/// drawn with replacement, in pairs, because both see the same picture. The draws are the same in every run. `None`
/// without frames, or where a median is not positive.
pub(super) fn ratio(times: &[f64], against: &[f64]) -> Option<Ratio> {
    let count = times.len().min(against.len());
    let of = |places: &[usize]| {
        let pick = |from: &[f64]| median(&places.iter().map(|place| from[*place]).collect::<Vec<_>>());
        pick(times) / pick(against)
    };
    let all: Vec<usize> = (0..count).collect();
    let of_medians = of(&all);
    if count == 0 || !of_medians.is_finite() || of_medians <= 0.0 {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let resampled: Vec<f64> = (0..RESAMPLES)
        .map(|_| of(&(0..count).map(|_| rng.random_range(0..count)).collect::<Vec<_>>()))
        .collect();
    Some(Ratio {
        of_medians,
        low: quantile(&resampled, (1.0 - CONFIDENCE) / 2.0),
        high: quantile(&resampled, (1.0 + CONFIDENCE) / 2.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_between_their_neighbours() {
        let values = [40.0, 10.0, 30.0, 20.0];
        assert_eq!(
            [0.0, 0.25, 0.5, 1.0].map(|share| quantile(&values, share)),
            [10.0, 17.5, 25.0, 40.0]
        );
        assert_eq!(
            (median(&[3.0, 100.0, 1.0]), median(&[7.0]), median(&[])),
            (3.0, 7.0, 0.0)
        );
    }

    #[test]
    fn lows_are_means_of_the_slowest_hundredth() {
        // 1..=200 ms: the slowest hundredth is two frames, 199 and 200.
        let times: Vec<f64> = (1..=200).map(f64::from).collect();
        assert_eq!(low_1_percent(&times), 199.5);
        // 101 frames: a hundredth is more than one frame, so two are taken.
        assert_eq!(low_1_percent(&times[..101]), 100.5);
        assert_eq!(low_1_percent(&[5.0, 9.0, 7.0]), 9.0, "of few frames the slowest one");
        assert_eq!(low_1_percent(&[]), 0.0);
    }

    #[test]
    fn a_constant_factor_has_no_spread() {
        // The frames differ by a factor of ten, the techniques always by three: only pairs see that.
        let against: Vec<f64> = (1..=20).map(|frame| f64::from(frame * frame)).collect();
        let times: Vec<f64> = against.iter().map(|time| 3.0 * time).collect();
        let found = ratio(&times, &against).expect("there are frames");
        for value in [found.of_medians, found.low, found.high] {
            assert!((value - 3.0).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn noise_widens_the_interval() {
        let against = [10.0; 20];
        let noisy: Vec<f64> = (0..20).map(|frame| if frame % 2 == 0 { 10.0 } else { 30.0 }).collect();
        let found = ratio(&noisy, &against).expect("there are frames");
        assert_eq!(found.of_medians, 2.0);
        assert_eq!((found.low, found.high), (1.0, 3.0));
        let calm: Vec<f64> = (0..20).map(|frame| if frame % 2 == 0 { 19.0 } else { 21.0 }).collect();
        let calm = ratio(&calm, &against).expect("there are frames");
        assert!(calm.low >= 1.9 && calm.high <= 2.1, "{calm:?}");
    }

    #[test]
    fn intervals_are_those_of_the_binomial_distribution() {
        // Times of 1 to n against 1: a resample's median is at most k with the probability that more than half of n
        // draws are at most k, a binomial sum. For n = 5, k = 1 that is 0.058; for n = 21 it is 0.018 at k = 6 and 0.056
        // at k = 7. The upper ends mirror the lower ones.
        let found = |count: u32| {
            let times: Vec<f64> = (1..=count).map(f64::from).collect();
            ratio(&times, &vec![1.0; times.len()]).expect("there are frames")
        };
        assert_eq!((found(5).low, found(5).high), (1.0, 5.0));
        let of_21 = found(21);
        assert_eq!(of_21.of_medians, 11.0);
        assert!((6.0..=7.0).contains(&of_21.low), "{of_21:?}");
        assert!((15.0..=16.0).contains(&of_21.high), "{of_21:?}");
    }

    #[test]
    fn nothing_has_no_ratio() {
        assert_eq!(ratio(&[], &[]), None);
        assert_eq!(ratio(&[1.0], &[0.0]), None);
    }
}
