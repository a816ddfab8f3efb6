//! Stretch and simple shear against the closed forms kept beside the project.

use nalgebra::Matrix2;
use serde_json::Value;
use simulation::law::{Law, Material};

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// `(what is stretched how, the law, its key)`.
const LAWS: [(Law, &str); 2] = [(Law::StVenantKirchhoff, "svk"), (Law::NeoHookean, "nh")];

/// Rounding of a dozen operations on numbers of the size of the answer.
fn close(found: f64, expected: f64) -> bool {
    (found - expected).abs() <= 2e-14 * expected.abs().max(1.0)
}

fn stretched(material: &Material, s: f64, lateral: f64) -> (f64, f64, f64) {
    let g = Matrix2::new(s - 1.0, 0.0, 0.0, lateral - 1.0);
    let at = material.response(&g).expect("no inversion");
    (at.density, at.stress[0], at.stress[3])
}

#[test]
fn stretches_and_shears_agree_with_the_closed_forms() {
    let Some(oracle) = crate::common::oracle() else { return };
    let rows = oracle["closed_forms"]["rows"].as_array().expect("rows");
    let mut checked = 0;
    for row in rows {
        let nu = number(&row["nu"]);
        for (law, key) in LAWS {
            let material = Material::new(law, 1.0, nu).expect("a material");
            match row["kind"].as_str() {
                Some("stretch") => stretch(row, &material, key),
                _ => shear(row, &material, key),
            }
            checked += 1;
        }
    }
    assert_eq!(checked, 80);
}

fn stretch(row: &Value, material: &Material, key: &str) {
    let s = number(&row["s"]);
    let confined = &row[format!("confined_{key}")];
    let (w, p11, p22) = stretched(material, s, 1.0);
    assert!(
        close(w, number(&confined["w"])) && close(p11, number(&confined["P11"])),
        "{row} {w} {p11}"
    );
    assert!(close(p22, number(&confined["P22"])), "{row} {p22}");
    let uniaxial = &row[format!("uniaxial_{key}")];
    let Some(lateral) = uniaxial["lateral"].as_f64() else {
        return;
    };
    let (w, p11, p22) = stretched(material, s, lateral);
    // The oracle's lateral stretch is a root found to 1e-12 or so.
    let near = |a: f64, b: f64| (a - b).abs() < 1e-11 * (1.0 + b.abs());
    assert!(
        near(w, number(&uniaxial["w"])) && near(p11, number(&uniaxial["P11"])) && near(p22, 0.0),
        "{row} {p22}"
    );
}

fn shear(row: &Value, material: &Material, key: &str) {
    let g = Matrix2::new(0.0, number(&row["gamma"]), 0.0, 0.0);
    let at = material.response(&g).expect("no inversion");
    let expected = &row[key];
    assert!(close(at.density, number(&expected["w"])), "{row}");
    for i in 0..2 {
        for j in 0..2 {
            let entry = at.stress[i + 2 * j];
            assert!(close(entry, number(&expected["P"][i][j])), "{row} {i}{j} {entry}");
        }
    }
}
