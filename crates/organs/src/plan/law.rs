//! The law of an organ, checked.

use simulation::law::{Law, Ogden};

use super::super::raw::{RawOrgan, RawSpaceLaw};
use crate::numbers::{Checked, invalid};

/// The largest exponent of an Ogden law, in size: a stretch of 2 to the power of 30 is 1e9, and Newton's steps end there.
const MOST_EXPONENT: f64 = 30.0;
const TERMS: &str =
    "1 to 3 terms [weight, exponent], each product above 0, exponents from -30 to 30; weights count by their ratio";

/// The law of organ `k`, and its name in a scene.
pub(super) fn law(k: usize, raw: &RawOrgan) -> Checked<(&'static str, Law)> {
    let key = format!("organs.{k}.ogden");
    let plain = match raw.law {
        RawSpaceLaw::StVenantKirchhoff => ("st-venant-kirchhoff", Law::StVenantKirchhoff),
        RawSpaceLaw::Linear => ("linear", Law::Linear),
        RawSpaceLaw::NeoHookean => ("neo-hookean", Law::NeoHookean),
        RawSpaceLaw::StableNeoHookean => ("stable-neo-hookean", Law::StableNeoHookean),
        RawSpaceLaw::Ogden => {
            let Some(terms) = &raw.ogden else {
                return Err(invalid(key, "nothing, with law = \"ogden\"", TERMS));
            };
            return Ok(("ogden", Law::Ogden(ogden(key, terms)?)));
        }
    };
    match raw.ogden {
        Some(_) => Err(invalid(
            key,
            format!("terms with law = {:?}", plain.0),
            "law = \"ogden\", or no terms",
        )),
        None => Ok(plain),
    }
}

fn ogden(key: String, terms: &[[f64; 2]]) -> Checked<Ogden> {
    let steep = terms.iter().find(|[_, a]| a.abs() > MOST_EXPONENT);
    if let Some([weight, exponent]) = steep {
        return Err(invalid(key, format!("[{weight}, {exponent}]"), TERMS));
    }
    let terms: Vec<(f64, f64)> = terms.iter().map(|[m, a]| (*m, *a)).collect();
    Ogden::new(&terms).map_err(|refused| invalid(key, refused, TERMS))
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;
    use simulation::space::law::Material;

    use super::*;

    fn of(lines: &str) -> Checked<(&'static str, Law)> {
        let rest =
            "name = \"ball\"\nlabel = 1\nyoung = 0.01\npoisson = 0.45\nsmoothing = 3.0\ncubes = { side = 12.0 }\n";
        law(3, &toml::from_str(&format!("{rest}{lines}")).unwrap())
    }

    /// `m = mu` and exponent 2: `mu/2 (tr F^T F - 3) - mu ln J + lambda/2 (ln J)^2` is the neo-Hookean law, which is taken where none is named.
    #[test]
    fn one_term_of_exponent_2_is_neo_hookean() {
        let density = |lines: &str| {
            let material = Material::new(of(lines).unwrap().1, 0.01, 0.45).unwrap();
            let gradient = Matrix3::new(0.3, 0.1, -0.2, 0.05, -0.4, 0.1, 0.0, 0.2, 0.15);
            material.density(&gradient).unwrap()
        };
        let plain = density("");
        assert_eq!(of("").unwrap().0, "neo-hookean");
        for weight in ["1.0", "0.003"] {
            let ogden = density(&format!("law = \"ogden\"\nogden = [[{weight}, 2.0]]"));
            // Some tens of roundings of terms that are of the size of the sum.
            assert!((ogden / plain - 1.0).abs() < 1e-13, "{ogden} {plain}");
        }
        let stiff = density("law = \"ogden\"\nogden = [[1.0, 8.0], [-1.0, -8.0]]");
        assert!(stiff > 1.1 * plain, "{stiff} {plain}");
    }
}
