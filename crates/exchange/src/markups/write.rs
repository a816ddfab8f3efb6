//! From markups to the text of a file.

use serde_json::{Map, Value, json};

use super::{Markup, Markups};
use crate::{ControlPoint, PatientAxes};

/// The schema that is written: every Slicer since 5.0 takes it.
const SCHEMA: &str = "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#";

/// The text of a file of the points that have a place, whose coordinates are along these axes, in mm, each number with the digits that bring back every
/// bit.
pub fn write(file: &Markups, axes: PatientAxes) -> String {
    let markups: Vec<Value> = file.markups.iter().map(|markup| of_markup(markup, axes)).collect();
    // By hand around the markups: Slicer tells such a file by this key within its first 300 bytes.
    let markups = serde_json::to_string_pretty(&markups).unwrap_or_default();
    format!(
        "{{\n  \"@schema\": \"{SCHEMA}\",\n  \"markups\": {}\n}}\n",
        markups.replace('\n', "\n  ")
    )
}

fn of_markup(markup: &Markup, axes: PatientAxes) -> Value {
    let mut value = Map::new();
    value.insert("type".to_owned(), json!(markup.kind.name()));
    if !markup.name.is_empty() {
        value.insert("name".to_owned(), json!(markup.name));
    }
    value.insert("coordinateSystem".to_owned(), json!(axes.name()));
    value.insert("coordinateUnits".to_owned(), json!("mm"));
    let points = markup.points.iter().map(|point| of_point(point, axes));
    value.insert("controlPoints".to_owned(), points.collect());
    Value::Object(value)
}

fn of_point(point: &ControlPoint, axes: PatientAxes) -> Value {
    json!({
        "id": point.id,
        "label": point.label,
        "description": point.description,
        "associatedNodeID": point.associated_node,
        "position": axes.turned(point.position.mm()),
        "selected": point.selected,
        "locked": point.locked,
        "visibility": point.visible,
        "positionStatus": "defined",
    })
}
