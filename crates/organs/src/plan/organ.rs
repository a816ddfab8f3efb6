//! Organs of a scene, checked.

use simulation::law::Refused;
use simulation::space::cells::{Parts, Settings, Smoothing};
use simulation::space::law::Material;

use super::super::raw::{RawOrgan, RawParts};
use super::Organ;
use super::numbers::length;
use super::spread::{poisson, young};
use crate::numbers::{Checked, invalid, within};

/// Cubes of an organ: a scene must not ask for hours without a word.
const MOST_CUBES: usize = 20_000;
/// From this Poisson's ratio on, conditions of the systems exceed what was tried.
const MOST_POISSON: f64 = 0.4999;

pub(super) fn organ((k, raw): (usize, &RawOrgan)) -> Checked<Organ> {
    let key = |last: &str| format!("organs.{k}.{last}");
    if raw.label == 0 {
        return Err(invalid(
            key("label"),
            0,
            "a label of the map, above 0: 0 is what has none",
        ));
    }
    let (name, law) = super::law::law(k, raw)?;
    let prefix = format!("organs.{k}");
    let young = young(&prefix, raw.young, raw.young_spread)?;
    if raw.poisson > MOST_POISSON {
        return Err(invalid(
            key("poisson"),
            raw.poisson,
            format!("above -1, at most {MOST_POISSON}"),
        ));
    }
    let material = Material::new(law, raw.young, raw.poisson).map_err(|refused| match refused {
        Refused::Young { .. } => invalid(key("young"), refused, "a stiffness above 0, N/mm2"),
        _ => invalid(key("poisson"), refused, format!("above -1, at most {MOST_POISSON}")),
    })?;
    let poisson = poisson(&prefix, raw.poisson, raw.poisson_spread, MOST_POISSON)?;
    let good = (0.0..=100.0).contains(&raw.smoothing);
    good.then_some(())
        .ok_or_else(|| invalid(key("smoothing"), raw.smoothing, "0 to 100 mm"))?;
    let levels = raw.cubes.levels;
    within(
        &key("cubes.levels"),
        levels as usize,
        0..=Settings::MOST_LEVELS as usize,
    )?;
    if raw.cubes.within.len() != levels as usize {
        let allowed = format!("as many distances as levels, {levels}: of each halving, how near to the tube's way");
        return Err(invalid(
            key("cubes.within"),
            format!("{} numbers", raw.cubes.within.len()),
            allowed,
        ));
    }
    for (i, near) in raw.cubes.within.iter().enumerate() {
        length(&key(&format!("cubes.within.{i}")), *near)?;
    }
    Ok(Organ {
        name: raw.name.clone(),
        label: raw.label,
        law: name,
        ogden: raw.ogden.clone(),
        material,
        young,
        poisson,
        smoothing: Smoothing {
            sigma: raw.smoothing,
            parts: match raw.parts {
                RawParts::Refuse => Parts::Refuse,
                RawParts::Largest => Parts::Largest,
            },
            fill_holes: raw.fill_holes,
        },
        settings: Settings {
            levels,
            most_cubes: MOST_CUBES,
            ..Settings::of_side(length(&key("cubes.side"), raw.cubes.side)?)
        },
        within: raw.cubes.within.clone(),
    })
}
