//! The wires of a phantom, of a device set's `PhantomDefinition`.

use roxmltree::Node;

use super::PlusError;
use super::read::{document, text};
use crate::quoted;

/// The most wires that are read.
pub const MAX_WIRES: usize = 100;
/// No phantom is longer, mm.
const MOST_MM: f64 = 1e4;

/// A wire by its ends in the phantom's frame, mm.
#[derive(Debug, Clone, PartialEq)]
pub struct PhantomWire {
    /// As in the file.
    pub name: String,
    /// `EndPointFront`.
    pub front_mm: [f64; 3],
    /// `EndPointBack`.
    pub back_mm: [f64; 3],
}

/// The wires of all patterns, in their order. Names are one each.
///
/// # Errors
/// [`PlusError::TooLong`], [`PlusError::Xml`], [`PlusError::WireCount`], [`PlusError::Wire`], [`PlusError::Twice`].
pub fn wires(bytes: &[u8]) -> Result<Vec<PhantomWire>, PlusError> {
    let text = text(bytes)?;
    let document = document(text)?;
    let definitions = document
        .root_element()
        .children()
        .filter(|node| node.has_tag_name("PhantomDefinition"));
    let nodes: Vec<Node<'_, '_>> = definitions
        .flat_map(|node| node.descendants())
        .filter(|node| node.has_tag_name("Wire"))
        .collect();
    if !(1..=MAX_WIRES).contains(&nodes.len()) {
        return Err(PlusError::WireCount {
            found: nodes.len(),
            most: MAX_WIRES,
        });
    }
    let mut all: Vec<PhantomWire> = Vec::new();
    for node in nodes {
        let next = wire(document.text_pos_at(node.range().start).row, &node)?;
        if all.iter().any(|other| other.name == next.name) {
            return Err(PlusError::Twice { name: next.name });
        }
        all.push(next);
    }
    Ok(all)
}

fn wire(line: u32, node: &Node<'_, '_>) -> Result<PhantomWire, PlusError> {
    let refused = |key, expected| PlusError::Wire {
        line,
        key,
        found: format!("{:?}", quoted(node.attribute(key).unwrap_or_default())),
        expected,
    };
    let name = node.attribute("Name").unwrap_or_default();
    if name.is_empty() || name.len() > 64 || name.contains(char::is_control) {
        return Err(refused("Name", "the name of a wire"));
    }
    let end = |key: &'static str| {
        let words = node.attribute(key).unwrap_or_default().split_ascii_whitespace();
        // One more than it has, so that a fourth is seen.
        let numbers: Option<Vec<f64>> = words.take(4).map(|word| word.parse().ok()).collect();
        let numbers: Option<[f64; 3]> = numbers.and_then(|n| n.try_into().ok());
        // A NaN is below nothing.
        let numbers = numbers.filter(|n| n.iter().all(|x| x.abs() <= MOST_MM));
        numbers.ok_or_else(|| refused(key, "three numbers of at most 10000 mm"))
    };
    Ok(PhantomWire {
        name: name.to_owned(),
        front_mm: end("EndPointFront")?,
        back_mm: end("EndPointBack")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(wires: &str) -> String {
        format!(
            "<PlusConfiguration><PhantomDefinition><Geometry><Pattern>{wires}</Pattern></Geometry></PhantomDefinition></PlusConfiguration>"
        )
    }

    #[test]
    fn wires_are_read_or_refused_by_line() {
        let a = r#"<Wire Name="7:G1_g1" EndPointFront="30.0 0.0 20.0" EndPointBack="30.0 40.0 20.0" />"#;
        let found = wires(file(a).as_bytes()).unwrap();
        assert_eq!(
            (found[0].name.as_str(), found[0].back_mm),
            ("7:G1_g1", [30.0, 40.0, 20.0])
        );
        let wrong = |text: &str| wires(file(text).as_bytes()).unwrap_err().to_string();
        assert_eq!(wrong(""), "0 wires in its PhantomDefinition; 1 to 100 are read");
        assert!(wrong(&(a.to_owned() + a)).starts_with("7:G1_g1 is in the file more than once"));
        for (bad, words) in [
            (
                a.replace("30.0 0.0 20.0", "30.0 nan 20.0"),
                "EndPointFront of a Wire is \"30.0 nan 20.0\"",
            ),
            (
                a.replace("30.0 40.0 20.0", "30.0 40.0 20.0 1"),
                "EndPointBack of a Wire is",
            ),
            (a.replace("7:G1_g1", ""), "Name of a Wire is \"\""),
        ] {
            assert!(wrong(&bad).contains(words), "{}", wrong(&bad));
        }
    }
}
