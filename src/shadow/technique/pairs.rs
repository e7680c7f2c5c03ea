//! Keys with their values: the topics that own them, and how they are read.

use super::{
    base::BASES, error::TechniqueError, fit_keys, lookup_keys, measured_keys, path_keys, seam_keys, stable_keys,
    stock_keys,
};
use crate::shadow::settings::SunShadows;

/// One key.
pub(super) struct Key {
    /// Its name.
    pub(super) name: &'static str,
    /// The values that it takes, for messages.
    pub(super) values: &'static str,
    /// Whether it means nothing on the drop-in path.
    pub(super) is_full_only: bool,
}

impl Key {
    /// A key of both paths.
    pub(super) const fn new(name: &'static str, values: &'static str) -> Self {
        Self {
            name,
            values,
            is_full_only: false,
        }
    }

    /// A key of the full path.
    pub(super) const fn full(name: &'static str, values: &'static str) -> Self {
        Self {
            name,
            values,
            is_full_only: true,
        }
    }
}

/// Keys that belong together: their table, how they reach the settings, and the text of settings.
pub(super) struct Topic {
    /// The keys.
    pub(super) keys: &'static [Key],
    /// Writes the keys that were given into the settings. Topics are read in the order of [`topics`]: first the path.
    pub(super) read: fn(&mut SunShadows, &Pairs) -> Result<(), TechniqueError>,
    /// `key=value` of everything that differs between settings and defaults of the same base.
    pub(super) changes: fn(&SunShadows, &SunShadows) -> Vec<String>,
}

/// The topics of every base but `bevy`; the keys of its own topics come after the first.
pub(super) fn topics(own: &'static [&'static Topic]) -> impl Iterator<Item = &'static Topic> {
    let after: [&'static Topic; 5] = [
        &seam_keys::TOPIC,
        &lookup_keys::TOPIC,
        &fit_keys::TOPIC,
        &measured_keys::TOPIC,
        &stable_keys::TOPIC,
    ];
    std::iter::once(&path_keys::TOPIC)
        .chain(own.iter().copied())
        .chain(after)
}

/// Every key of every base, once.
pub(super) fn all_keys() -> Vec<&'static Key> {
    let mut keys: Vec<&Key> = Vec::new();
    let tables = BASES
        .into_iter()
        .flat_map(|base| topics(base.topics))
        .map(|topic| topic.keys);
    for key in tables.chain([stock_keys::KEYS]).flatten() {
        if !keys.iter().any(|known| known.name == key.name) {
            keys.push(key);
        }
    }
    keys
}

/// Every key with each set of values that it takes, once, and the bases whose own it is; none where it is of all of them.
pub(super) fn keys_of_bases() -> Vec<(&'static Key, Vec<&'static str>)> {
    let mut keys: Vec<(&Key, Vec<&str>)> = Vec::new();
    let common = topics(&[]).map(|topic| (topic, None));
    let own = BASES
        .into_iter()
        .flat_map(|base| base.topics.iter().map(|topic| (*topic, Some(base.names))));
    let tables = common.chain(own).map(|(topic, names)| (topic.keys, names));
    for (table, names) in tables.chain([(stock_keys::KEYS, Some("bevy"))]) {
        for key in table {
            let is_same = |known: &Key| (known.name, known.values) == (key.name, key.values);
            match keys.iter_mut().find(|(known, _)| is_same(known)) {
                Some((_, bases)) => bases.extend(names.filter(|name| !bases.contains(name))),
                None => keys.push((key, names.into_iter().collect())),
            }
        }
    }
    keys
}

/// Keys with their values, checked against [`all_keys`]. A name may mean one thing to one base and another to the next.
pub(super) struct Pairs<'a>(Vec<(&'static Key, &'a str)>);

impl<'a> Pairs<'a> {
    /// Reads `key=value,key=value` for a base with these topics of its own.
    pub(super) fn parse(text: &'a str, own: &'static [&'static Topic]) -> Result<Self, TechniqueError> {
        let known: Vec<&Key> = topics(own).flat_map(|topic| topic.keys).chain(all_keys()).collect();
        let mut pairs: Vec<(&'static Key, &'a str)> = Vec::new();
        for pair in text.split(',').map(str::trim).filter(|pair| !pair.is_empty()) {
            let (name, value) = pair.split_once('=').unwrap_or((pair, ""));
            let Some(key) = known.iter().find(|key| key.name == name) else {
                return Err(TechniqueError::Key { name: name.to_owned() });
            };
            if pairs.iter().any(|(given, _)| given.name == name) {
                return Err(TechniqueError::Twice(name.to_owned()));
            }
            pairs.push((key, value));
        }
        Ok(Self(pairs))
    }

    /// The keys that were given.
    pub(super) fn keys(&self) -> impl Iterator<Item = &'static Key> {
        self.0.iter().map(|(key, _)| *key)
    }

    /// Whether a key was given.
    pub(super) fn has(&self, name: &str) -> bool {
        self.keys().any(|key| key.name == name)
    }

    /// The value of a key, if it was given, as `parse` reads it; `None` from `parse` is a wrong value.
    pub(super) fn read<T>(
        &self,
        name: &str,
        parse: impl FnOnce(&str) -> Option<T>,
    ) -> Result<Option<T>, TechniqueError> {
        let Some(&(key, value)) = self.0.iter().find(|(key, _)| key.name == name) else {
            return Ok(None);
        };
        parse(value).map(Some).ok_or_else(|| TechniqueError::Value {
            key: key.name,
            value: value.to_owned(),
            expected: key.values.to_owned(),
        })
    }
}

/// A finite number within a range.
pub(super) fn number(text: &str, range: impl std::ops::RangeBounds<f32>) -> Option<f32> {
    text.parse::<f32>()
        .ok()
        .filter(|value| value.is_finite() && range.contains(value))
}

/// A length: above zero.
pub(super) fn metres(text: &str) -> Option<f32> {
    number(text, f32::MIN_POSITIVE..)
}

/// `auto` or a length.
pub(super) fn auto_or_metres(text: &str) -> Option<Option<f32>> {
    if text == "auto" {
        Some(None)
    } else {
        metres(text).map(Some)
    }
}

/// `on` or `off`.
pub(super) fn switch(text: &str) -> Option<bool> {
    match text {
        "on" => Some(true),
        "off" => Some(false),
        _ => None,
    }
}

/// The text of [`switch`].
pub(super) fn switch_text(is_on: bool) -> &'static str {
    if is_on { "on" } else { "off" }
}
