//! Materials of a scene.

use simulation::law::{Law, Material, Ogden, Refused};

use crate::scene::raw::{RawLaw, RawMaterial};
use crate::scene::{Checked, invalid, short_name, within};

/// From this ratio on plain elements lock, whatever the law.
const MIXED_FROM: f64 = 0.495;

/// A material and the form of its elements.
#[derive(Debug, Clone)]
pub(super) struct Form {
    pub(super) name: String,
    pub(super) material: Material,
    pub(super) mixed: bool,
}

pub(super) fn materials(raw: &[RawMaterial]) -> Checked<Vec<Form>> {
    within("materials", raw.len(), 0..=100)?;
    super::names("materials", raw.iter().map(|m| m.name.as_str()))?;
    raw.iter().enumerate().map(form).collect()
}

fn form((k, raw): (usize, &RawMaterial)) -> Checked<Form> {
    short_name(&format!("materials.{k}.name"), &raw.name)?;
    let refused = |refused: Refused| {
        let (last, allowed) = match refused {
            Refused::Young { .. } => ("young", "a stiffness above 0, units of stress"),
            Refused::Poisson { .. } => (
                "poisson",
                "above -1 and below 0.5; nearly incompressible: 0.4999 with mixed = true",
            ),
            _ => ("ogden", "1 to 3 terms [weight, exponent], each product above 0"),
        };
        let found = format!("material {:?}: {refused}", raw.name);
        invalid(format!("materials.{k}.{last}"), found, allowed)
    };
    let law = match (raw.law, &raw.ogden) {
        (RawLaw::Ogden, Some(terms)) => {
            let terms: Vec<(f64, f64)> = terms.iter().map(|[m, a]| (*m, *a)).collect();
            Law::Ogden(Ogden::new(&terms).map_err(refused)?)
        }
        (RawLaw::Ogden, None) => {
            let allowed = "with law = \"ogden\": its terms [[weight, exponent], ...]";
            return Err(invalid(format!("materials.{k}.ogden"), "nothing", allowed));
        }
        (_, Some(_)) => {
            let found = format!("terms with law {:?}", raw.law);
            return Err(invalid(
                format!("materials.{k}.ogden"),
                found,
                "law = \"ogden\", or no terms",
            ));
        }
        (RawLaw::StVenantKirchhoff, None) => Law::StVenantKirchhoff,
        (RawLaw::Linear, None) => Law::Linear,
        (RawLaw::NeoHookean, None) => Law::NeoHookean,
        (RawLaw::StableNeoHookean, None) => Law::StableNeoHookean,
    };
    let material = Material::new(law, raw.young, raw.poisson).map_err(refused)?;
    if raw.poisson >= MIXED_FROM && !raw.mixed {
        let found = format!(
            "material {:?}: {} with plain elements, which lock",
            raw.name, raw.poisson
        );
        let allowed = format!("below {MIXED_FROM}, or mixed = true");
        return Err(invalid(format!("materials.{k}.poisson"), found, allowed));
    }
    Ok(Form {
        name: raw.name.clone(),
        material,
        mixed: raw.mixed,
    })
}
