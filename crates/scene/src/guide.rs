//! `[guide]`: the target that is aimed at from the start, and what identifies a plan.

use geometry::Point;
use serde::{Deserialize, Serialize};

use super::Target;

/// `[guide]`
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawGuide {
    /// Name of a target. Absent: none is chosen until a person chooses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<String>,
}

/// Identifies the plan of a target by its numbers (centre, radius, entry, stop distance; mm): 64 bits of BLAKE3, never 0.
pub fn plan_id(target: &Target) -> u64 {
    let mut hasher = blake3::Hasher::new_derive_key("trocar plan 1");
    let entry = target.entry.map(Point::mm);
    let numbers = target
        .centre
        .mm()
        .into_iter()
        .chain([target.diameter_mm / 2.0, target.stop_mm]);
    for number in numbers.chain(entry.into_iter().flatten()) {
        hasher.update(&number.to_bits().to_le_bytes());
    }
    let bytes = hasher.finalize();
    u64::from_be_bytes(std::array::from_fn(|i| bytes.as_bytes()[i])).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use std::path::Path;

    #[test]
    fn a_plan_is_known_by_each_of_its_numbers() {
        let text = "[[targets]]\nname = \"a\"\nct_mm = [1, 2, 3]\nentry_ct_mm = [4, 5, 6]\nstop_mm = 7";
        let plan = Scene::parse(text, Path::new("s.toml")).unwrap().targets[0].clone();
        let same = Target {
            name: "another".to_owned(),
            ..plan.clone()
        };
        assert_eq!(plan_id(&plan), plan_id(&same));
        let others = [
            Target {
                diameter_mm: 5.1,
                ..plan.clone()
            },
            Target {
                stop_mm: 0.0,
                ..plan.clone()
            },
            Target {
                entry: None,
                ..plan.clone()
            },
            Target {
                entry: Some(Point::new(4.0, 5.0, 6.5)),
                ..plan.clone()
            },
            Target {
                centre: Point::new(1.0, 2.0, 3.0000001),
                ..plan.clone()
            },
        ];
        let ids: std::collections::BTreeSet<u64> = others.iter().chain([&plan]).map(plan_id).collect();
        assert_eq!(ids.len(), others.len() + 1);
    }
}
