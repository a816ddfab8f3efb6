//! Numbers of a scene that are not known exactly: their standard deviations, and the plan with one of them moved.

use simulation::space::law::Material;

use super::{Attachment, Organ, Plan};
use crate::numbers::{Checked, invalid, positive};

/// The largest standard deviation of a logarithm: a factor of e up or down.
const MOST_LOG: f64 = 1.0;
/// Derivatives by Poisson's ratio are taken over this part of its standard deviation: beyond 0.49 what volume resists by doubles within a hundredth,
/// and forces, unlike places, are far from linear in it.
const SMALL_PART: f64 = 1e-3;

/// A number with its standard deviation, where one is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Given {
    /// Of Young's moduli N/mm^2.
    pub value: f64,
    /// Standard deviation; of Young's moduli that of their logarithm.
    pub spread: Option<f64>,
}

/// What an uncertain number is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Which {
    /// Of an organ.
    Young(usize),
    /// Of an organ.
    Poisson(usize),
    /// Of an attachment.
    Tie(usize),
    Bath,
}

/// A number of the scene that has a standard deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertain {
    which: Which,
    /// As the scene has it: `organs.0.young`.
    pub key: String,
    /// For people.
    pub name: String,
    /// Of Young's moduli N/mm^2.
    pub value: f64,
    /// A standard deviation up, and down.
    pub moved: [f64; 2],
}

impl Uncertain {
    /// The value that is so many standard deviations above the scene's: of Young's moduli by their logarithm.
    pub fn at(&self, deviations: f64) -> f64 {
        let up = self.moved[0];
        match self.which {
            Which::Poisson(_) => self.value + deviations * (up - self.value),
            _ => self.value * (up / self.value).powf(deviations),
        }
    }

    /// Values near it and weights: the weighted sum of a function of the number is its derivative times one standard deviation. Of Young's moduli by the
    /// logarithm, exact of what is linear in them, as all forces are.
    pub fn slope(&self) -> [(f64, f64); 2] {
        match self.which {
            Which::Poisson(_) => {
                let s = self.moved[0] - self.value;
                // Both sides: what bends falls out, and rounding is far below.
                let small = SMALL_PART * s;
                let weight = 0.5 / SMALL_PART;
                [(self.value + small, weight), (self.value - small, -weight)]
            }
            _ => {
                let s = (self.moved[0] / self.value).ln();
                [(2.0 * self.value, s), (self.value, -s)]
            }
        }
    }
}

/// Young's modulus under `prefix`.
pub(super) fn young(prefix: &str, value: f64, spread: Option<f64>) -> Checked<Given> {
    positive(&format!("{prefix}.young"), value)?;
    match spread {
        Some(found) if !(found > 0.0 && found <= MOST_LOG) => Err(invalid(
            format!("{prefix}.young_spread"),
            found,
            format!(
                "above 0, at most {MOST_LOG}: the standard deviation of young's logarithm, 0.3 for some 30 %; none where it is not known"
            ),
        )),
        _ => Ok(Given { value, spread }),
    }
}

/// Poisson's ratio under `prefix`, at most `most` when moved by its standard deviation.
pub(super) fn poisson(prefix: &str, value: f64, spread: Option<f64>, most: f64) -> Checked<Given> {
    // Rounding of a sum that a person made equal to the most is none of theirs.
    let fits = |s: f64| s > 0.0 && value + s <= most + 1e-12 && value - s > -1.0;
    match spread {
        Some(found) if !fits(found) => Err(invalid(
            format!("{prefix}.poisson_spread"),
            format!("{found}, beside a ratio of {value}"),
            format!(
                "above 0, so that poisson + poisson_spread is at most {most} and poisson - poisson_spread above -1"
            ),
        )),
        _ => Ok(Given { value, spread }),
    }
}

impl Plan {
    /// All numbers that may have a standard deviation: what they are of, key, words, the number.
    fn numbers(&self) -> Vec<(Which, String, String, Given)> {
        let mut all = Vec::new();
        for (k, organ) in self.organs.iter().enumerate() {
            let one = |which, last: &str, given| {
                (
                    which,
                    format!("organs.{k}.{last}"),
                    format!("{last} of {}", organ.name),
                    given,
                )
            };
            all.push(one(Which::Young(k), "young", organ.young));
            all.push(one(Which::Poisson(k), "poisson", organ.poisson));
        }
        for (k, tie) in self.attachments.iter().enumerate() {
            if let Some(young) = tie.young {
                let to: Vec<&str> = tie.to.iter().map(|r| self.rigid[*r].name.as_str()).collect();
                let name = format!("young between {} and {}", self.organs[tie.organ].name, to.join(", "));
                all.push((Which::Tie(k), format!("attachments.{k}.young"), name, young));
            }
        }
        if let Some(bath) = &self.bath {
            all.push((
                Which::Bath,
                "surroundings.young".to_owned(),
                "young of the surroundings".to_owned(),
                bath.young,
            ));
        }
        all
    }

    /// All numbers with a standard deviation.
    pub fn uncertain(&self) -> Vec<Uncertain> {
        let each = self.numbers().into_iter().filter_map(|(which, key, name, given)| {
            let (value, s) = (given.value, given.spread?);
            let moved = match which {
                Which::Poisson(_) => [value + s, value - s],
                _ => [value * s.exp(), value * (-s).exp()],
            };
            Some(Uncertain {
                which,
                key,
                name,
                value,
                moved,
            })
        });
        each.collect()
    }

    /// Keys of the numbers that could have a standard deviation and have none.
    pub fn taken_as_exact(&self) -> Vec<String> {
        let all = self.numbers().into_iter().filter(|n| n.3.spread.is_none());
        all.map(|n| n.1).collect()
    }

    /// The same plan with one number moved. `None` where no material has it.
    pub fn with(&self, one: &Uncertain, value: f64) -> Option<Self> {
        let mut plan = self.clone();
        let part = value / one.value;
        match one.which {
            Which::Young(k) => plan.organs[k].remade(value, self.organs[k].poisson.value)?,
            Which::Poisson(k) => plan.organs[k].remade(self.organs[k].young.value, value)?,
            Which::Tie(k) => plan.attachments[k].scaled(part),
            Which::Bath => {
                if let Some(bath) = &mut plan.bath {
                    bath.stiffness *= part;
                }
            }
        }
        Some(plan)
    }
}

impl Organ {
    fn remade(&mut self, young: f64, poisson: f64) -> Option<()> {
        self.material = Material::new(self.material.law, young, poisson).ok()?;
        Some(())
    }
}

impl Attachment {
    fn scaled(&mut self, part: f64) {
        self.stiffness = self.stiffness.map(|s| s * part);
    }
}
