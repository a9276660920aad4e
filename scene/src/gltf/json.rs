//! From the JSON of a file to a document of types.
//!
//! The crate's types are stricter than the format in some places and laxer in others. So the JSON is first read as it is, and
//! put in order:
//! - What is not taken, animations and cameras, is counted and removed, whatever extensions it has.
//! - A scene may be empty (section 5.27: `nodes` is not required).
//! - The crate cuts integers to 32 bits. What is larger becomes a float, which no index can be; sizes in bytes may be so large.
//! - A number that single precision cannot have would become infinite, and is an error.

use gltf::json::Root;
use serde::Deserialize;
use serde_json::{Number, Value, json};

use super::GltfFault;
use super::extensions::check_required;

/// What has to be known before the rest can be understood.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    asset: Asset,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Asset {
    version: String,
    min_version: Option<String>,
}

/// How many things of a file were removed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Removed {
    pub animations: usize,
    pub cameras: usize,
}

/// Members that may be larger than 32 bits: sizes in bytes, and counts that are held against them.
const SIZES: [&str; 3] = ["byteLength", "byteOffset", "count"];

/// Members whose numbers nothing here reads.
const UNREAD: [&str; 3] = ["extras", "min", "max"];

/// Reads the JSON of a file.
pub(super) fn read(text: &[u8]) -> Result<(Root, Removed), GltfFault> {
    let mut value: Value = serde_json::from_slice(text).map_err(GltfFault::Json)?;
    if let Ok(head) = Head::deserialize(&value) {
        check_version(&head.asset)?;
        check_required(&head.extensions_required)?;
    }
    let removed = put_in_order(&mut value);
    settle_numbers(&mut value).map_err(|wrong| GltfFault::Thing {
        thing: wrong.place.trim_start_matches('.').to_owned(),
        what: wrong.what,
    })?;
    let root = serde_path_to_error::deserialize(value).map_err(|error| GltfFault::Member {
        place: error.path().to_string(),
        source: error.into_inner(),
    })?;
    Ok((root, removed))
}

/// Whether the version is known: a later one with the same major number can be read, unless it says otherwise (section 3.2).
fn check_version(asset: &Asset) -> Result<(), GltfFault> {
    let is_known = |version: &str| version == "2.0" || version == "2";
    let Asset {
        version,
        min_version,
    } = asset;
    let of_version_2 = version.split('.').next() == Some("2");
    let needed = min_version.as_deref().filter(|&version| !is_known(version));
    if !of_version_2 || needed.is_some() {
        let version = needed.unwrap_or(version).to_owned();
        return Err(GltfFault::Version { version });
    }
    Ok(())
}

fn put_in_order(value: &mut Value) -> Removed {
    let Some(root) = value.as_object_mut() else {
        return Removed::default();
    };
    let mut remove = |member: &str| {
        let removed = root.remove(member);
        removed.map_or(0, |removed| removed.as_array().map_or(0, Vec::len))
    };
    // Those that are required are known here, not all of them to the crate.
    remove("extensionsRequired");
    let removed = Removed {
        animations: remove("animations"),
        cameras: remove("cameras"),
    };
    let mut each = |array: &str, change: fn(&mut serde_json::Map<String, Value>)| {
        let elements = root.get_mut(array).and_then(Value::as_array_mut);
        for element in elements.into_iter().flatten() {
            element.as_object_mut().map(change);
        }
    };
    each("nodes", |node| {
        node.remove("camera");
    });
    each("scenes", |scene| {
        scene.entry("nodes").or_insert_with(|| json!([]));
    });
    removed
}

/// A number that cannot be, and where it is.
struct Unsettled {
    place: String,
    what: String,
}

/// Makes what is no 32-bit integer a float, and checks that floats are finite in single precision.
fn settle_numbers(value: &mut Value) -> Result<(), Unsettled> {
    let inside = |step: String| {
        move |Unsettled { place, what }| Unsettled {
            place: step + &place,
            what,
        }
    };
    match value {
        Value::Number(number) => {
            let Some(float) = number.as_f64() else {
                return Ok(());
            };
            if (float as f32).is_infinite() {
                return Err(Unsettled {
                    place: String::new(),
                    what: format!(
                        "{float:e} is over the limit {:e} of single precision",
                        f32::MAX
                    ),
                });
            }
            if number
                .as_u64()
                .is_some_and(|integer| integer > u64::from(u32::MAX))
                && let Some(float) = Number::from_f64(float)
            {
                *number = float;
            }
        }
        Value::Array(items) => {
            for (k, item) in items.iter_mut().enumerate() {
                settle_numbers(item).map_err(inside(format!("[{k}]")))?;
            }
        }
        Value::Object(members) => {
            for (name, member) in members.iter_mut() {
                if !SIZES.contains(&&name[..]) && !UNREAD.contains(&&name[..]) {
                    settle_numbers(member).map_err(inside(format!(".{name}")))?;
                }
            }
        }
        _ => {}
    }
    Ok(())
}
