//! Studies that take seconds.

use std::path::Path;

use study::plan::Plan;

/// Coarse voxels and large beads: an examination takes a second.
pub(crate) const QUICK: &str =
    "[all]\nct = { spacing_mm = [2.0, 2.0, 2.0], images = 1 }\nbeads = { diameter_mm = 4.0 }\n";

/// The study of a text.
pub(crate) fn plan(text: &str) -> Plan {
    Plan::of_texts([(Path::new("study.toml"), text)]).unwrap()
}

/// Six quick operations of two strata.
pub(crate) fn six() -> Plan {
    plan(&format!(
        "seed = 3\noperations = 3\n{QUICK}targets = [\"pre-aortic\", \"iliac-left\"]\n[[stratum]]\nname = \"a\"\n\
         [[stratum]]\nname = \"b\"\nbump = {{ share = 0.5 }}\n"
    ))
}
