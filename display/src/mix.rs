//! Factors of a solution's layers, as a command line has them: `lantern=0.3,ceiling panels=0`, or by channel, `lantern=1:0.5:0.2`.
//! Layers that are not named have the factor 1. Names are taken as they are, with commas and signs of equality if they have any.

use scene::layers::Layers;
use scene::{Rgb, Scene, SceneError, Solution};

/// Why layers cannot be mixed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum MixError {
    #[error("--mix: the file has no layers; compute --layers lamps makes one a lamp")]
    NoLayers,
    #[error("--mix {text}: \"{rest}\" begins with no layer's name and =; there are {names}")]
    Name {
        text: String,
        rest: String,
        names: String,
    },
    #[error(
        "--mix: factor {value} of layer \"{layer}\" is no number of at least 0, and no three of them, as in 1:0.5:0.2"
    )]
    Factor { layer: String, value: String },
    #[error("--mix: {0}")]
    Light(#[from] SceneError),
}

/// A scene and its solution as they are where layers have the factors that a text gives them.
pub fn mixed(
    scene: &Scene,
    solution: Option<&Solution>,
    text: &str,
) -> Result<(Scene, Solution), MixError> {
    let solution = solution.ok_or(MixError::NoLayers)?;
    let layers = solution.layers.as_ref().ok_or(MixError::NoLayers)?;
    let factors = factors(text, layers)?;
    match solution.mixed(scene, &factors) {
        Some(mixed) => Ok(mixed?),
        None => Err(MixError::NoLayers),
    }
}

/// The factors, one per layer.
fn factors(text: &str, layers: &Layers) -> Result<Vec<Rgb>, MixError> {
    let mut factors = vec![Rgb::ONE; layers.layers.len()];
    let mut rest = text;
    while !rest.is_empty() {
        let begun = layers.layers.iter().enumerate().filter_map(|(k, layer)| {
            let after = rest.strip_prefix(layer.name.as_str())?.strip_prefix('=')?;
            Some((layer.name.len(), k, after))
        });
        // Of names that begin alike the longest.
        let Some((_, layer, after)) = begun.max_by_key(|&(length, k, _)| (length, usize::MAX - k))
        else {
            let names = layers
                .layers
                .iter()
                .map(|layer| format!("\"{}\"", layer.name));
            return Err(MixError::Name {
                text: text.to_owned(),
                rest: rest.to_owned(),
                names: names.collect::<Vec<_>>().join(", "),
            });
        };
        let (value, next) = after.split_once(',').unwrap_or((after, ""));
        factors[layer] = factor(value).ok_or_else(|| MixError::Factor {
            layer: layers.layers[layer].name.clone(),
            value: value.to_owned(),
        })?;
        rest = next;
    }
    Ok(factors)
}

/// A number, or three for red, green and blue.
fn factor(text: &str) -> Option<Rgb> {
    let numbers: Option<Vec<f32>> = text.split(':').map(|n| n.trim().parse().ok()).collect();
    let factor = match numbers?[..] {
        [all] => Rgb::splat(all),
        [r, g, b] => Rgb::new(r, g, b),
        _ => return None,
    };
    (factor.is_finite() && factor.min_element() >= 0.0).then_some(factor)
}

#[cfg(test)]
mod tests {
    use scene::layers::{Layer, LayerKind};

    use super::*;

    fn layers(names: &[&str]) -> Layers {
        let layer = |name: &&str| Layer {
            name: (*name).to_owned(),
            lamp: None,
            irradiance: Vec::new(),
            vertices: Vec::new(),
        };
        Layers {
            kind: LayerKind::Bounces,
            layers: names.iter().map(layer).collect(),
        }
    }

    #[test]
    fn factors_are_by_name_and_one_where_nothing_is_said() {
        let layers = layers(&["a", "a=1,b", "c d"]);
        let of = |text| factors(text, &layers).unwrap();
        assert_eq!(of("c d=0.5"), [Rgb::ONE, Rgb::ONE, Rgb::splat(0.5)]);
        assert_eq!(
            of("a=2,c d=0:1:2"),
            [Rgb::splat(2.0), Rgb::ONE, Rgb::new(0.0, 1.0, 2.0)]
        );
        // The longer name.
        assert_eq!(of("a=1,b=3"), [Rgb::ONE, Rgb::splat(3.0), Rgb::ONE]);
    }

    #[test]
    fn what_is_wrong_is_told() {
        let layers = layers(&["a", "b"]);
        for (text, said) in [
            (
                "x=1",
                "\"x=1\" begins with no layer's name and =; there are \"a\", \"b\"",
            ),
            ("a=1,b", "\"b\" begins with no"),
            ("a=-1", "factor -1 of layer \"a\""),
            ("a=1:2", "factor 1:2"),
            ("a=inf", "factor inf"),
            ("a=", "factor  of"),
        ] {
            let error = factors(text, &layers).unwrap_err().to_string();
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
