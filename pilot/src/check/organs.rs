//! Whether the organs of a scene can be moved: what the process that moves them refuses at its start.

use scene::Scene;

use super::Checked;

/// How far organs are looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// The text of the scene of organs: its values and the tube.
    Text,
    /// That, and its label map beside the examination's voxels.
    Map,
    /// That, and all that is made of it at the start of a run.
    Meshes,
}

/// Looks at the organs of a scene: what was made of them, in words, or what would be refused.
pub(crate) type LookAtOrgans = fn(&Scene, Depth) -> Result<Option<String>, Box<dyn std::error::Error + Send + Sync>>;

/// What is found of the organs, and what is not looked at.
pub(super) fn look_at(scene: &Scene, depth: Depth, look: LookAtOrgans) -> Checked {
    let (made, fault) = match look(scene, depth) {
        Ok(made) => (made.map(|made| format!("organs {made}")), None),
        Err(why) => (None, Some(format!("the organs of [tissue]: {why}"))),
    };
    let note = match depth {
        _ if fault.is_some() => None,
        Depth::Text => {
            Some("note: the organs of [tissue] were not held against the examination, as one of the two is wrong")
        }
        Depth::Map => Some(
            "note: the organs of [tissue] were not meshed (--quick): whether their cubes and what holds them fit is found without --quick, and when \
             the run starts, which refuses what does not",
        ),
        Depth::Meshes => None,
    };
    Checked {
        lines: made.into_iter().chain(note.map(str::to_owned)).collect(),
        faults: fault.into_iter().collect(),
    }
}
