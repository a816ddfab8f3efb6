//! How much a model may be: refused by what is to be expected before anything is meshed, and by what meshes have.

use super::super::labels::Labels;
use super::super::plan::Plan;
use crate::numbers::{Checked, invalid};

/// Unknowns of all organs together. Factors of so many take some gigabytes.
pub(super) const MOST: usize = 150_000;
/// Unknowns of a cube inside an organ: three of each of the eight nodes that are its own, of 27 that it shares.
const PER_CUBE: f64 = 24.0;

/// Cubes of the given sides in the volumes of all organs, at the least, before any is halved.
///
/// # Errors
/// [`scene::Invalid`] with the cubes of the organ that makes it too many.
pub(super) fn expected(plan: &Plan, labels: &Labels) -> Checked<()> {
    let mut sum = 0.0;
    for (k, organ) in plan.organs.iter().enumerate() {
        let volume = labels.count(organ.label) as f64 * labels.spacing.product();
        sum += PER_CUBE * volume / organ.settings.side.powi(3);
        if sum > MOST as f64 {
            return Err(too_many(k, format!("{sum:.0} unknowns at the least")));
        }
    }
    Ok(())
}

/// Unknowns of the meshes up to that of an organ.
///
/// # Errors
/// [`scene::Invalid`] with its cubes.
pub(super) fn most(k: usize, unknowns: usize) -> Checked<()> {
    if unknowns > MOST {
        return Err(too_many(k, format!("{unknowns} unknowns")));
    }
    Ok(())
}

fn too_many(k: usize, found: String) -> scene::Invalid {
    let allowed = format!("at most {MOST} of all organs together: larger cubes, or fewer halvings");
    invalid(
        format!("organs.{k}.cubes"),
        format!("{found}, with the organs before it"),
        allowed,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_of_too_many_unknowns_are_named_with_found_and_allowed() {
        assert!(most(1, MOST).is_ok());
        let refused = most(1, MOST + 1).unwrap_err();
        assert_eq!(refused.key, "organs.1.cubes");
        assert!(refused.found.contains("150001 unknowns") && refused.allowed.contains("150000"));
    }
}
