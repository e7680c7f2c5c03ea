//! Which nodes of a model file are which levels of which variant.

use serde::Deserialize;

/// A variant's nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Indices of its nodes from the finest level to the coarsest.
    pub nodes: Vec<usize>,
    /// Share of the picture's height down to which each is meant; 0 for a last one that never disappears.
    pub coverages: Vec<f32>,
}

#[derive(Deserialize)]
struct Extras {
    #[serde(rename = "MSFT_screencoverage")]
    coverages: Vec<f32>,
}

/// Groups nodes called `NAME_LOD0`, `NAME_LOD1`, … by name, in the order of their finest level. Nodes come with their
/// extras as JSON, which hold `MSFT_screencoverage` on the finest. Other nodes are left out.
///
/// # Errors
/// One clause: no such nodes, a level is missing, or coverages are missing or wrong.
pub fn variants<'a>(nodes: impl Iterator<Item = (&'a str, Option<&'a str>)>) -> Result<Vec<Variant>, String> {
    let mut found: Vec<(&str, Variant)> = Vec::new();
    for (index, (name, extras)) in nodes.enumerate() {
        let Some((variant, level)) = name.rsplit_once("_LOD") else {
            continue;
        };
        let Ok(level) = level.parse::<usize>() else { continue };
        if level == 0 {
            let coverages = match extras.map(serde_json::from_str::<Extras>) {
                Some(Ok(extras)) => extras.coverages,
                None => Vec::new(),
                Some(Err(error)) => return Err(format!("node {name} has unreadable extras ({error})")),
            };
            let nodes = vec![index];
            found.push((variant, Variant { nodes, coverages }));
        } else {
            match found.iter_mut().find(|(name, _)| *name == variant) {
                Some((_, own)) if own.nodes.len() == level => own.nodes.push(index),
                _ => return Err(format!("node {name} comes before the level above it")),
            }
        }
    }
    if found.is_empty() {
        return Err("it has no node whose name ends in _LOD0".into());
    }
    for (name, variant) in &mut found {
        if variant.coverages.is_empty() && variant.nodes.len() == 1 {
            variant.coverages.push(0.0);
        }
        let fits = variant.coverages.len() == variant.nodes.len();
        if !fits || !variant.coverages.iter().all(|coverage| (0.0..=1.0).contains(coverage)) {
            return Err(format!(
                "{name} has {} levels, but its MSFT_screencoverage is {:?}",
                variant.nodes.len(),
                variant.coverages
            ));
        }
    }
    Ok(found.into_iter().map(|(_, variant)| variant).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_grouped_by_name_and_level() {
        let extras = Some(r#"{"MSFT_screencoverage":[0.4,0.0],"other":1}"#);
        let nodes = [
            ("oak_a_LOD0", extras),
            ("oak_a_LOD1", None),
            ("camera", None),
            ("oak_b_LOD0", None),
        ];
        let variants = variants(nodes.into_iter()).unwrap();
        let expected = [
            Variant {
                nodes: vec![0, 1],
                coverages: vec![0.4, 0.0],
            },
            Variant {
                nodes: vec![3],
                coverages: vec![0.0],
            },
        ];
        assert_eq!(variants, expected);
    }

    #[test]
    fn what_is_wrong_is_said() {
        let say = |nodes: &[(&'static str, Option<&'static str>)]| variants(nodes.iter().copied()).unwrap_err();
        assert!(say(&[("tree", None)]).contains("_LOD0"));
        assert!(say(&[("a_LOD0", None), ("a_LOD2", None)]).contains("a_LOD2"));
        assert!(say(&[("a_LOD0", None), ("a_LOD1", None)]).contains("2 levels"));
        assert!(say(&[("a_LOD0", Some(r#"{"MSFT_screencoverage":[3.0]}"#))]).contains("3.0"));
        assert!(say(&[("a_LOD0", Some("{"))]).contains("unreadable"));
    }
}
