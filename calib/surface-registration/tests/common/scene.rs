//! The pelvis that most tests register to.

use geometry::Ct;
use surface_registration::{Field, Spacing, Surface};

use super::draw::Source;
use super::oracle;

/// The oracle's phantom with its field, and what draws points on it.
pub(crate) struct Scene {
    pub(crate) surface: Surface<Ct>,
    pub(crate) field: Field,
    pub(crate) source: Source,
}

/// The pelvis; `None`, with a printed reason, where the oracles are not there.
pub(crate) fn scene() -> Option<Scene> {
    let bone = oracle::bone("pelvis-phantom")?;
    let surface = Surface::new(&bone.0, &bone.1).unwrap();
    Some(Scene {
        field: Field::new(&surface, Spacing::default()).unwrap(),
        surface,
        source: Source::new(&bone),
    })
}
