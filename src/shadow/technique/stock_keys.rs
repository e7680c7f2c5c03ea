//! Keys of `bevy`, the stock cascades, and their text.

use super::{
    StockBias,
    error::TechniqueError,
    pairs::{Key, Pairs, number},
};

pub(super) const KEYS: &[Key] = &[
    Key::new("depth_bias", "metres >= 0, for bevy"),
    Key::new("normal_bias", "texels >= 0, for bevy"),
];

/// Reads the keys.
pub(super) fn read(pairs: &Pairs) -> Result<StockBias, TechniqueError> {
    if let Some(key) = pairs.keys().find(|key| !is_stock(key)) {
        return Err(TechniqueError::together(format!(
            "`bevy` takes no key `{}`, only depth_bias and normal_bias",
            key.name
        )));
    }
    let not_negative = |text: &str| number(text, 0.0..);
    let default = StockBias::default();
    Ok(StockBias {
        depth: pairs.read("depth_bias", not_negative)?.unwrap_or(default.depth),
        normal: pairs.read("normal_bias", not_negative)?.unwrap_or(default.normal),
    })
}

/// Whether a key is one of these.
pub(super) fn is_stock(key: &Key) -> bool {
    KEYS.iter().any(|stock| stock.name == key.name)
}

/// `key=value` of the biases that are not Bevy's own.
pub(super) fn changes(bias: StockBias) -> Vec<String> {
    let default = StockBias::default();
    let mut pairs = Vec::new();
    if bias.depth != default.depth {
        pairs.push(format!("depth_bias={}", bias.depth));
    }
    if bias.normal != default.normal {
        pairs.push(format!("normal_bias={}", bias.normal));
    }
    pairs
}
