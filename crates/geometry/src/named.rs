//! Transforms between frames that are named in a file, `StylusToTracker` and the like, and chains of them.
//!
//! A name `AToB` says `b_from_a`: it takes coordinates in A to coordinates in B, as the PLUS toolkit has it. Asked for a transform
//! that a file does not hold, [`Chain::find`] looks for the shortest way from one frame to the other over those that it
//! holds, each forwards or backwards. Names are case sensitive.
//!
//! Where a name has several `To` (`StylusToToolToTracker`) that begin a frame, the one is taken that leaves two frames which
//! other names have; where none or several do, that name is in no chain.
//!
//! Where there is another way besides, [`Chain::pose`] goes both and refuses where they end apart.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;

use crate::{Named, Rigid};

/// A transform between frames whose names are known at run time only.
pub type NamedRigid = Rigid<Named, Named>;

/// The most names that chains are looked for in.
pub const MAX_NAMES: usize = 256;
/// How far two ways may end apart: six digits of a matrix lose 1e-6 of 2 m a link, and a recorder writes each link so.
pub const APART_MM: f64 = 0.05;
/// The same of the rotation, radians.
pub const APART_RAD: f64 = 1e-4;

/// One transform of a chain.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Link {
    /// As in the file, without a suffix.
    pub name: String,
    /// Taken backwards.
    pub inverse: bool,
}

/// The way from one frame to another, and others that must end in the same place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chain {
    links: Vec<Link>,
    others: Vec<Vec<Link>>,
}

/// Why there is no chain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NoChain {
    /// Nothing leads there.
    Missing {
        /// What was asked for.
        asked: String,
    },
    /// What was asked for can be read as several pairs of frames between which there is a way.
    Ambiguous {
        /// What was asked for.
        asked: String,
        /// The pairs.
        readings: String,
    },
    /// So many names that this is no recording of tools.
    TooMany {
        /// Their number.
        found: usize,
    },
}

/// Two ways that end apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Disagree {
    /// The way that was taken.
    pub a: String,
    /// Another one.
    pub b: String,
    /// How far apart, mm.
    pub mm: f64,
    /// How far turned, radians.
    pub rad: f64,
}

impl fmt::Display for NoChain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing { asked } => {
                write!(
                    f,
                    "there is no transform {asked}, and none can be composed of what there is"
                )
            }
            Self::Ambiguous { asked, readings } => write!(f, "the name {asked} can be read as {readings}"),
            Self::TooMany { found } => {
                write!(f, "{found} transforms; chains are looked for among {MAX_NAMES} at most")
            }
        }
    }
}

impl std::error::Error for NoChain {}

impl fmt::Display for Disagree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { a, b, mm, rad } = self;
        write!(
            f,
            "{a} and {b} end {mm:.3} mm and {rad:.1e} rad apart, at most {APART_MM} mm and {APART_RAD:e} rad are taken for \
             rounding: which of them holds is not said"
        )
    }
}

impl std::error::Error for Disagree {}

impl fmt::Display for Link {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let back = if self.inverse { "inverse " } else { "" };
        write!(f, "{back}{}", self.name)
    }
}

impl fmt::Display for Chain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&words(&self.links))
    }
}

fn words(links: &[Link]) -> String {
    links.iter().map(Link::to_string).collect::<Vec<_>>().join(", then ")
}

impl Chain {
    /// The shortest chain of `names` for what is `asked`: that name itself where there is one.
    ///
    /// # Errors
    /// [`NoChain`].
    pub fn find(names: &BTreeSet<&str>, asked: &str) -> Result<Self, NoChain> {
        if names.contains(asked) {
            let name = asked.to_owned();
            let (links, others) = (vec![Link { name, inverse: false }], Vec::new());
            return Ok(Self { links, others });
        }
        // Each name may be an edge and ways are looked for once more without each link: a hostile file must not make
        // that long.
        if names.len() > MAX_NAMES {
            return Err(NoChain::TooMany { found: names.len() });
        }
        let edges = edges(names);
        let ways = splits(asked).into_iter();
        let ways: Vec<_> = ways
            .filter_map(|(from, to)| Some(((from, to), way(&edges, from, to, None)?)))
            .collect();
        match &ways[..] {
            [] => Err(NoChain::Missing { asked: quoted(asked) }),
            [((from, to), links)] => {
                // Every other way leaves out at least one link of the shortest.
                let without = links.iter().filter_map(|l| way(&edges, from, to, Some(&l.name)));
                let others: BTreeSet<Vec<Link>> = without.collect();
                Ok(Self {
                    links: links.clone(),
                    others: others.into_iter().collect(),
                })
            }
            several => {
                let each = several
                    .iter()
                    .map(|((from, to), _)| format!("{} to {}", quoted(from), quoted(to)));
                Err(NoChain::Ambiguous {
                    asked: quoted(asked),
                    readings: each.collect::<Vec<_>>().join(" and as "),
                })
            }
        }
    }

    /// The transforms taken, first to last.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// The names whose transforms are asked for.
    pub fn names(&self) -> BTreeSet<&str> {
        let all = self.links.iter().chain(self.others.iter().flatten());
        all.map(|link| link.name.as_str()).collect()
    }

    /// What the chain takes to where, of one frame's transforms: `None` where one of its links is not there or not valid.
    ///
    /// # Errors
    /// [`Disagree`] where another way whose links are all valid ends apart.
    pub fn pose(&self, of: impl Fn(&str) -> Option<NamedRigid>) -> Result<Option<NamedRigid>, Disagree> {
        let Some(pose) = along(&self.links, &of) else {
            return Ok(None);
        };
        for other in &self.others {
            // A way of which a link is missing in this frame says nothing against the other.
            let Some(second) = along(other, &of) else { continue };
            let between = pose.inverse() * second;
            let mm = between.translation_mm().iter().map(|x| x * x).sum::<f64>().sqrt();
            let rad = between.angle();
            // A NaN is not near.
            let near = mm <= APART_MM && rad <= APART_RAD;
            if !near {
                let (a, b) = (words(&self.links), words(other));
                return Err(Disagree { a, b, mm, rad });
            }
        }
        Ok(Some(pose))
    }
}

fn along(links: &[Link], of: impl Fn(&str) -> Option<NamedRigid>) -> Option<NamedRigid> {
    links.iter().try_fold(NamedRigid::identity(), |pose, link| {
        let next = of(&link.name)?;
        Some(if link.inverse { next.inverse() } else { next } * pose)
    })
}

/// Where a name can be parted: `To`, with something before it, and behind it what begins as a frame does.
fn splits(name: &str) -> Vec<(&str, &str)> {
    let begins = |c: char| c.is_uppercase() || c.is_ascii_digit();
    let part = |(at, _): (usize, &str)| {
        let (from, to) = (&name[..at], &name[at + 2..]);
        (!from.is_empty() && to.starts_with(begins)).then_some((from, to))
    };
    name.match_indices("To").filter_map(part).collect()
}

/// By frame: the frame that a name leads to, and the link.
type Edges<'a> = BTreeMap<&'a str, Vec<(&'a str, Link)>>;

fn edges<'a>(names: &BTreeSet<&'a str>) -> Edges<'a> {
    let parted: Vec<_> = names.iter().map(|name| (*name, splits(name))).collect();
    let clear = parted.iter().filter(|(_, splits)| splits.len() == 1);
    let known: BTreeSet<&str> = clear.flat_map(|(_, s)| [s[0].0, s[0].1]).collect();
    // Filled in the order of `names`, which is sorted: the search meets a frame's links in the same order every time.
    let mut edges = Edges::new();
    for (name, splits) in &parted {
        let both = |(from, to): &&(&str, &str)| splits.len() == 1 || known.contains(from) && known.contains(to);
        let mut told = splits.iter().filter(both);
        let (Some((from, to)), None) = (told.next(), told.next()) else {
            continue;
        };
        for (a, b, inverse) in [(from, to, false), (to, from, true)] {
            let name = (*name).to_owned();
            edges.entry(a).or_default().push((b, Link { name, inverse }));
        }
    }
    edges
}

/// The shortest way, by breadth; of ways of one length the one whose names come first.
fn way(edges: &Edges<'_>, from: &str, to: &str, without: Option<&str>) -> Option<Vec<Link>> {
    let mut came: BTreeMap<&str, Vec<Link>> = BTreeMap::from([(from, Vec::new())]);
    let mut open = VecDeque::from([from]);
    while let Some(at) = open.pop_front() {
        for (next, link) in edges.get(at).into_iter().flatten() {
            if came.contains_key(next) || without == Some(&link.name) {
                continue;
            }
            let way = [&came[at][..], std::slice::from_ref(link)].concat();
            if *next == to {
                return Some(way);
            }
            came.insert(next, way);
            open.push_back(next);
        }
    }
    None
}

/// What is quoted in errors stays short, whatever a file holds.
fn quoted(text: &str) -> String {
    text.chars().take(60).collect()
}
