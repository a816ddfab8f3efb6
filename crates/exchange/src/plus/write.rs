//! From transforms to the text of a device set.

use std::fmt::Write;

use super::DeviceSet;

/// The text of a device set with these transforms and no device: its `CoordinateDefinitions` go into another by copying them. Each number
/// has the digits that bring back every bit.
pub fn write(set: &DeviceSet) -> String {
    let mut text = "<PlusConfiguration version=\"2.3\">\n  <CoordinateDefinitions>\n".to_owned();
    for one in &set.definitions {
        let [from, to] = [&one.from, &one.to].map(|name| escaped(name));
        let rows = one
            .rows
            .map(|row| row.map(|x| x.to_string()).join(" "))
            .join("\n        ");
        // Writing to a string does not fail.
        let _ = write!(
            text,
            "    <Transform From=\"{from}\" To=\"{to}\"\n      Matrix=\"\n        {rows}\""
        );
        let _ = one
            .error
            .map_or(Ok(()), |error| write!(text, "\n      Error=\"{error}\""));
        let _ = one
            .date
            .as_ref()
            .map_or(Ok(()), |date| write!(text, "\n      Date=\"{}\"", escaped(date)));
        text.push_str(" />\n");
    }
    text + "  </CoordinateDefinitions>\n</PlusConfiguration>\n"
}

/// As the value of an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
