//! Which views agree on one camera, where all of them together do not.
//!
//! A mixture of two cameras, or a focus that was moved between pictures, leaves residuals in every view: the adjustment lies
//! between the two. So small groups are calibrated, and the one whose discs agree best is grown view by view.

use super::once;
use super::view::{ImageSize, LEAST_VIEWS, Options, View};

/// The most views among which groups are looked for.
const MOST_VIEWS: usize = 64;
/// The most groups of three that are calibrated: of two cameras with as many views each, one in four has one camera, and
/// forty that have nothing to do with one another miss all of them once in 10^5.
const MAX_TRIPLES: usize = 40;
/// A view belongs to a group if the ratio of the group with it is at most this times what the group began with: discs of
/// another camera leave more.
const MAX_RATIO_GROWTH: f64 = 1.5;
/// How many groups of three are grown: three views of two cameras may agree by chance, but then no other view does.
const MAX_GROWN_TRIPLES: usize = 4;

/// Views that agree on one camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Agreeing {
    /// Whether each view is of the group.
    pub group: Vec<bool>,
    /// The larger of the two ratios of the group alone ([`super::Calibrated::noise_ratio`], [`super::Calibrated::view_ratio`]).
    pub ratio: f64,
    /// The same of all other views, where these agree on a camera of their own.
    pub others: Option<f64>,
}

/// The largest group found of at least three views, not all, that agree on one camera to a ratio of `limit`. None where no
/// three do, where all do, and of more than 64 views. A plate's field is taken for a paraboloid here.
pub fn agreeing(views: &[View], size: ImageSize, options: &Options, limit: f64) -> Option<Agreeing> {
    if views.len() <= LEAST_VIEWS || views.len() > MOST_VIEWS {
        return None;
    }
    let search = Search { views, size, options };
    let begun = triples(views.len()).into_iter();
    let mut begun: Vec<Group> = begun.filter_map(|triple| search.group(triple.to_vec())).collect();
    begun.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
    begun.dedup_by(|a, b| a.views == b.views);
    let grown = begun.into_iter().filter(|g| g.ratio <= limit).take(MAX_GROWN_TRIPLES);
    let grown: Vec<Group> = grown.map(|group| search.grown(group, limit)).collect();
    let group = grown.into_iter().reduce(|best, next| {
        if next.views.len() > best.views.len() {
            next
        } else {
            best
        }
    })?;
    let others: Vec<usize> = (0..views.len()).filter(|v| !group.views.contains(v)).collect();
    (!others.is_empty()).then(|| Agreeing {
        group: (0..views.len()).map(|v| group.views.contains(&v)).collect(),
        ratio: group.ratio,
        others: search.group(others).map(|g| g.ratio).filter(|r| *r <= limit),
    })
}

/// Some views and their ratio.
struct Group {
    views: Vec<usize>,
    ratio: f64,
}

struct Search<'a> {
    views: &'a [View],
    size: ImageSize,
    options: &'a Options,
}

impl Search<'_> {
    /// Some views alone; none where they give no camera.
    fn group(&self, some: Vec<usize>) -> Option<Group> {
        let views: Vec<View> = some.iter().map(|v| self.views[*v].clone()).collect();
        let options = Options {
            bent: self.options.bent || self.options.field,
            field: false,
            ..*self.options
        };
        let ratio = once(&views, self.size, &options)
            .ok()
            .map(|f| f.noise_ratio.max(f.view_ratio))?;
        Some(Group { views: some, ratio })
    }

    /// The group with every view that agrees with it.
    fn grown(&self, mut group: Group, limit: f64) -> Group {
        let most = limit.min(MAX_RATIO_GROWTH * group.ratio.max(1.0));
        for view in 0..self.views.len() {
            if group.views.contains(&view) {
                continue;
            }
            let with = self.group([&group.views[..], &[view]].concat());
            if let Some(with) = with.filter(|with| with.ratio <= most) {
                group = with;
            }
        }
        group
    }
}

/// All groups of three where they are few; else some of all kinds, neighbours too: what is moved once is moved between
/// two pictures.
fn triples(views: usize) -> Vec<[usize; 3]> {
    let pairs = (0..views).flat_map(|a| (a + 1..views).map(move |b| [a, b]));
    let all: Vec<[usize; 3]> = pairs
        .flat_map(|[a, b]| (b + 1..views).map(move |c| [a, b, c]))
        .collect();
    // A step that shares no factor with their number goes once round through all of them, far apart.
    let step = (all.len() * 5 / 13..)
        .find(|step| gcd(*step, all.len()) == 1)
        .unwrap_or(1);
    let neighbours = (0..views.saturating_sub(2)).map(|a| [a, a + 1, a + 2]);
    let few = neighbours.step_by(3).take(MAX_TRIPLES / 2);
    let scattered = (0..all.len().min(MAX_TRIPLES)).map(|k| all[k * step % all.len()]);
    few.chain(scattered).collect()
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
