//! [`TechniqueError`].

use thiserror::Error;

use super::{base::available, pairs::all_keys, warps};

/// Why a text is no technique.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TechniqueError {
    /// No such base.
    #[error("there is no technique `{name}`; available are {}", available())]
    Base {
        /// What was given.
        name: String,
    },
    /// No such warp.
    #[error("there is no warp `{name}`; available are {}", warps::names())]
    Warp {
        /// What was given.
        name: String,
    },
    /// A number of partitions out of range.
    #[error("`{text}`: {expected}")]
    Count {
        /// The base.
        text: String,
        /// How its partitions are counted.
        expected: &'static str,
    },
    /// A base that takes no warp.
    #[error("`{base}` takes no {what}")]
    Takes {
        /// The base.
        base: &'static str,
        /// What was given to it.
        what: &'static str,
    },
    /// No such key.
    #[error("there is no key `{name}`; keys are {}", key_list())]
    Key {
        /// The key given.
        name: String,
    },
    /// A key that was given twice.
    #[error("the key `{0}` is given twice")]
    Twice(String),
    /// A value that the key does not take.
    #[error("`{key}={value}` is wrong: `{key}` takes {expected}")]
    Value {
        /// The key.
        key: &'static str,
        /// The value given.
        value: String,
        /// The values that it takes.
        expected: String,
    },
    /// Settings that contradict each other.
    #[error("{0}")]
    Together(String),
}

impl TechniqueError {
    /// Settings that contradict each other, in a sentence.
    pub(super) fn together(text: impl Into<String>) -> Self {
        Self::Together(text.into())
    }
}

fn key_list() -> String {
    let names: Vec<_> = all_keys().into_iter().map(|key| key.name).collect();
    names.join(", ")
}
