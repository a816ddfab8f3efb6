//! Keys that are not read, and what they say of axes and units: it must be what is taken.

use std::fmt;

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::Value;

use super::MarkupsError;
use crate::named::named_in;
use crate::units::{About, about, units_in};
use crate::{LengthUnit, PatientAxes, quoted};

/// Keys of the schema that are passed over: none of them says where anything is.
pub(super) const PASSED_OVER: [&str; 8] = [
    "locked",
    "fixedNumberOfControlPoints",
    "labelFormat",
    "lastUsedControlPointNumber",
    "curveClosed",
    "measurements",
    "display",
    "orientation",
];
/// Keys with their values, in the order of the file, also those that are there twice.
pub(super) struct Rest(pub(super) Vec<(String, Value)>);

/// What is taken of a markup.
#[derive(Clone, Copy)]
pub(super) struct Taken {
    pub(super) axes: PatientAxes,
    pub(super) unit: LengthUnit,
}

impl<'de> Deserialize<'de> for Rest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Keys;
        impl<'de> Visitor<'de> for Keys {
            type Value = Rest;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("keys")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Rest, A::Error> {
                let mut keys = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    keys.push(entry);
                }
                Ok(Rest(keys))
            }
        }
        deserializer.deserialize_map(Keys)
    }
}

impl Rest {
    /// The keys that are named as left out.
    pub(super) fn keys(&self) -> impl Iterator<Item = &str> {
        let keys = self.0.iter().map(|(key, _)| key.as_str());
        keys.filter(|key| !PASSED_OVER.contains(key))
    }

    /// Refuses a key about units or axes, however deep, whose value is not what is taken, and a text that names others alone.
    ///
    /// # Errors
    /// [`MarkupsError::Claim`].
    pub(super) fn agree(&self, place: &str, taken: Taken) -> Result<(), MarkupsError> {
        let keys = self.0.iter().filter(|(key, _)| !PASSED_OVER.contains(&key.as_str()));
        keys.map(|(key, value)| (key, value))
            .try_for_each(|(key, value)| agree(place, key, value, taken))
    }
}

fn agree(place: &str, key: &str, value: &Value, taken: Taken) -> Result<(), MarkupsError> {
    let is_same = match (about(key), value) {
        (_, Value::Object(keys)) => return keys.iter().try_for_each(|(key, value)| agree(place, key, value, taken)),
        (Some(About::Unit), value) => is_unit(value, taken.unit),
        (Some(About::Axes), Value::String(word)) => PatientAxes::of_word(word) == Some(taken.axes),
        (Some(About::Axes), value) => PatientAxes::of_word(&value.to_string()) == Some(taken.axes),
        (None, Value::Array(values)) => {
            return values.iter().try_for_each(|value| agree(place, key, value, taken));
        }
        (None, Value::String(text)) => names(text, taken),
        (None, _) => true,
    };
    match is_same {
        true => Ok(()),
        false => Err(MarkupsError::Claim {
            place: place.to_owned(),
            key: quoted(key),
            found: quoted(&value.to_string()),
            axes: taken.axes.name(),
            unit: taken.unit.name(),
        }),
    }
}

/// Whether a value says mm, as its code or as code, coding scheme and meaning.
pub(super) fn is_mm(found: &Value) -> bool {
    match found {
        Value::Array(coded) => coded.len() == 3 && coded[0] == "mm" && coded[1] == "UCUM",
        other => other == "mm",
    }
}

fn is_unit(value: &Value, unit: LengthUnit) -> bool {
    match unit {
        LengthUnit::Millimetre => is_mm(value),
        LengthUnit::Metre => value == "m",
    }
}

/// Whether a text names no axes and no unit, or those that are taken among others.
fn names(text: &str, taken: Taken) -> bool {
    let (axes, units) = (named_in(text), units_in(text));
    let are_taken = axes.iter().any(|named| named.axes == Some(taken.axes));
    let is_taken = units.iter().any(|named| named.unit == Some(taken.unit));
    (axes.is_empty() || are_taken) && (units.is_empty() || is_taken)
}
