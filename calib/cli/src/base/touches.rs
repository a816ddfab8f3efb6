//! Touches on the base as comma-separated values, a touch a line.

use std::path::Path;

use calib::base::{Feature, Group, Refused, separated};
use geometry::{Frame, Point};

use crate::bundle::covariance;
use crate::input_files::columns::{Layout, Table, TableError};
use crate::input_files::points_text::{COVARIANCE, SHARED};
use crate::input_files::source::Source;
use crate::live::shared;

const LAYOUT: Layout = Layout {
    needed: &["x", "y", "z"],
    optional: &[&["on"], &COVARIANCE, &SHARED],
    hint: "x,y,z and, optionally, on (plane, groove 0, groove 1, groove 2, or any name of a group to be found) and \
           cxx,cxy,cxz,cyy,cyz,czz with u1x,u1y,u1z,u2x,u2y,u2z,u3x,u3y,u3z, in any order",
};

/// Touches by group.
#[derive(Debug)]
pub(super) struct Touches<F: Frame> {
    pub(super) groups: Vec<Group<F>>,
    /// The name of each group in the file.
    pub(super) names: Vec<String>,
    /// The line of each touch.
    pub(super) lines: Vec<Vec<usize>>,
    pub(super) count: usize,
    pub(super) source: Source,
}

/// The feature that a name says.
fn said(name: &str) -> Option<Feature> {
    let name: String = name.to_lowercase().split([' ', '-', '_']).collect();
    match name.as_str() {
        "plane" => Some(Feature::Plane),
        "groove0" => Some(Feature::Groove(0)),
        "groove1" => Some(Feature::Groove(1)),
        "groove2" => Some(Feature::Groove(2)),
        _ => None,
    }
}

/// What is left when touches come without groups.
const FOUND: [&str; 4] = ["line 1", "line 2", "line 3", "the rest"];

impl<F: Frame> Touches<F> {
    /// Reads touches; rows of one name are a group, in the order in which the names come. Without the column `on` the touches
    /// are sorted out, with `gate_mm` as the largest distance from a line.
    pub(super) fn read(path: &Path, gate_mm: f64) -> Result<Result<Self, Refused>, TableError> {
        Self::from_source(Source::read(path)?, gate_mm)
    }

    fn from_source(source: Source, gate_mm: f64) -> Result<Result<Self, Refused>, TableError> {
        let table = Table::new(&source, &LAYOUT)?;
        let noisy = table.has(COVARIANCE[0]);
        let (mut names, mut groups, mut lines) =
            (Vec::<String>::new(), Vec::<Group<F>>::new(), Vec::<Vec<usize>>::new());
        let rows = table.rows(&LAYOUT)?;
        for row in &rows {
            let name: String = row.text("on").chars().take(40).collect();
            if name.is_empty() && table.has("on") {
                return Err(row.bad(
                    "on",
                    "plane, groove 0, groove 1, groove 2, or a name for a group to be found",
                ));
            }
            let [x, y, z] = row.point(["x", "y", "z"])?;
            let group = names.iter().position(|known| *known == name).unwrap_or(names.len());
            if group == names.len() {
                groups.push(Group {
                    feature: said(&name),
                    ..Group::unlabelled(Vec::new())
                });
                names.push(crate::text::shown(&name));
                lines.push(Vec::new());
            }
            groups[group].touches.push(Point::new(x, y, z));
            lines[group].push(row.line);
            if noisy {
                groups[group].covariances.push(covariance(row)?);
            }
            if table.has(SHARED[0]) {
                groups[group].shared.push(shared(row)?);
            }
        }
        let (count, sorted) = (rows.len(), table.has("on"));
        let touches = Self {
            groups,
            names,
            lines,
            count,
            source,
        };
        Ok(if sorted {
            Ok(touches)
        } else {
            touches.sorted_out(gate_mm)
        })
    }

    /// The one group of touches without a name as three lines and the rest.
    fn sorted_out(self, gate_mm: f64) -> Result<Self, Refused> {
        let (groups, lines) = (&self.groups[0], &self.lines[0]);
        let parts = separated(&groups.touches, gate_mm)?;
        let group = |list: &Vec<usize>| {
            let covariances = list.iter().filter_map(|i| groups.covariances.get(*i).copied());
            let touches = list.iter().map(|i| groups.touches[*i]).collect();
            let shared = list.iter().filter_map(|i| groups.shared.get(*i).copied());
            Group::unlabelled(touches)
                .with_covariances(covariances.collect())
                .with_shared(shared.collect())
        };
        Ok(Self {
            names: FOUND.map(str::to_owned).into(),
            lines: parts
                .iter()
                .map(|list| list.iter().map(|i| lines[*i]).collect())
                .collect(),
            groups: parts.iter().map(group).collect(),
            ..self
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Tracker;
    use proptest::prelude::*;

    fn parse(text: &str) -> Result<Touches<Tracker>, String> {
        let source = Source::from_bytes(Path::new("t.csv"), text.into()).map_err(|e| e.to_string())?;
        let read = Touches::from_source(source, 1.2).map_err(|e| e.to_string())?;
        read.map_err(|e| e.to_string())
    }

    #[test]
    fn names_make_groups_and_say_features() {
        let found = parse("on,x,y,z\nGroove 1,1,2,3\na,4,5,6\ngroove_1,7,8,9\nPlane,0,0,0\nGroove 1,1,1,1\n").unwrap();
        assert_eq!(found.names, ["Groove 1", "a", "groove_1", "Plane"]);
        let features: Vec<_> = found.groups.iter().map(|g| g.feature).collect();
        let groove = Some(Feature::Groove(1));
        assert_eq!(features, [groove, None, groove, Some(Feature::Plane)]);
        assert_eq!(found.lines[0], [2, 6]);
    }

    #[test]
    fn touches_without_names_are_sorted_out() {
        let mut text = "x,y,z\n".to_owned();
        for i in 0..8 {
            let s = f64::from(i) * 7.0;
            text += &format!(
                "{s},0,-4\n0,{s},-4\n{s},{},-4\n{},{},0\n",
                90.0 - s,
                31.0 * (s * 3.0).sin(),
                43.0 * (s * 5.0).cos()
            );
        }
        let found = parse(&text).unwrap();
        assert_eq!(found.groups.iter().map(|g| g.touches.len()).sum::<usize>(), 32);
        // The corner of two lines goes to one of them.
        assert!(
            found.groups[..3]
                .iter()
                .all(|g| g.touches.len() >= 7 && g.feature.is_none())
        );
        let error = parse("x,y,z\n1,2,3\n4,5,6\n").unwrap_err();
        assert!(error.contains("a groove needs 4"), "{error}");
    }

    #[test]
    fn what_is_wrong_is_told() {
        for (text, words) in [
            ("on,x,y\n", "no column z"),
            ("on,x,y,z\n,1,2,3\n", "line 2, column 1 (on): found \"\""),
            ("on,x,y,z\nplane,1,2,inf\n", "(z): found \"inf\""),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(words), "{text}: {error}");
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "[pq0-9.,\n-]{0,120}") {
            let _ = parse(&format!("on,x,y,z\n{text}"));
            let _ = parse(&format!("x,y,z\n{text}"));
        }
    }
}
