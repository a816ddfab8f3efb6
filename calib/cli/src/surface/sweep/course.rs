//! The way of a tip over a bone: the points that are taken of it, and what the registration by them still lacks.

use geometry::{Ct, Direction, Marker, Point, Tool, Tracker, Uncertain, UncertainPoint, letters};
use nalgebra::{Matrix3, Vector3};
use surface_registration::{LEAST_POINTS, Touches, next};

use super::super::bone::Bone;
use super::super::error::SurfaceCommandError;
use super::super::{Asked, make};
use super::sounded::{Sounding, sounded_words};
use super::taken::Taken;
use crate::input_files::columns::TableError;
use crate::input_files::source::Source;
use crate::live::{Lacks, Listened, touches_comment};

/// How a way becomes points.
pub(super) struct Course<'a> {
    pub(super) tip: &'a Uncertain<Marker, Tool>,
    /// A point each so far, mm.
    pub(super) step_mm: f64,
    /// Faster is lifted, mm/s.
    pub(super) most_mm_s: f64,
    /// Deviation of the tip from the bone that it touches, along each axis, mm.
    pub(super) contact_mm: f64,
}

/// Points nearer to one another are one place touched again: how the tip lies on the bone there is no new chance, mm.
pub(super) const HELD_MM: f64 = 0.5;
/// Between two poses that are further apart in time nothing is known of the speed, s.
const GAP_S: f64 = 0.25;
/// Points from which on the registration is tried: with fewer a search finds as good as anything.
const ADVISED: usize = 2 * LEAST_POINTS;
/// So many points more at one place are reckoned with.
const MORE: f64 = 10.0;
/// Places that are told are so far from one another, mm.
const APART_MM: f64 = 40.0;

impl Course<'_> {
    /// Which poses are points: each the first one that is a step away from the point before, of a tip that is slow enough.
    fn taken<'h>(
        &self,
        heard: &'h Listened,
    ) -> impl Iterator<Item = (&'h Uncertain<Tracker, Marker>, UncertainPoint<Tracker>)> {
        let at = self.tip.transform() * Point::<Tool>::new(0.0, 0.0, 0.0);
        let (step_mm, most_mm_s) = (self.step_mm, self.most_mm_s);
        let mut before: Option<(f64, Point<Tracker>)> = None;
        let mut last: Option<Point<Tracker>> = None;
        let contact = Matrix3::identity() * (self.contact_mm * self.contact_mm);
        heard.poses.iter().zip(&heard.times_s).filter_map(move |(pose, t_s)| {
            let seen: UncertainPoint<Tracker> = *pose * at;
            let place = seen.point();
            let slow = before.is_some_and(|(then_s, there)| {
                let passed_s = t_s - then_s;
                (0.0..GAP_S).contains(&passed_s) && place.distance(there) <= most_mm_s * passed_s
            });
            before = Some((*t_s, place));
            let far = last.is_none_or(|last| place.distance(last) >= step_mm);
            if !(slow && far) {
                return None;
            }
            last = Some(place);
            UncertainPoint::new(place, seen.covariance() + contact)
                .ok()
                .map(|point| (pose, point))
        })
    }

    /// The file of the points: as `calib touch` has them, with the pose of the marker at each.
    pub(super) fn csv(&self, heard: &Listened, tool: &str, frame: &str) -> String {
        let mut text = format!(
            "{}\nx,y,z,cxx,cxy,cxz,cyy,cyz,czz,marker_qw,marker_qx,marker_qy,marker_qz,marker_x,marker_y,marker_z\n",
            touches_comment(tool, frame, self.tip)
        );
        for (pose, point) in self.taken(heard) {
            let c = point.covariance();
            let covariance = [c[(0, 0)], c[(0, 1)], c[(0, 2)], c[(1, 1)], c[(1, 2)], c[(2, 2)]];
            let rigid = pose.transform();
            let (q, t) = (rigid.quaternion(), rigid.translation_mm());
            let numbers = [&point.point().mm()[..], &covariance, &q, &t].concat();
            let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
            text += &(words.join(",") + "\n");
        }
        text
    }
}

/// What is swept with.
pub(super) enum Way<'a> {
    /// A pointer's tip on the bone; with its tool's name.
    Tip(Course<'a>, &'a str),
    /// A probe that sees the bone; with its tool's name.
    Probe(Sounding<'a>, &'a str),
}

impl Way<'_> {
    /// The points so far; `frame` is the name of theirs.
    pub(super) fn taken(&self, heard: &Listened, frame: &str) -> Taken {
        match self {
            Self::Tip(course, tool) => Taken {
                text: course.csv(heard, tool, frame),
                count: course.taken(heard).count(),
                refused: None,
            },
            Self::Probe(sounding, tool) => sounding.csv(heard, tool, frame),
        }
    }

    /// What is to be done next, where there are too few points yet.
    fn go_on(&self, heard: &Listened) -> String {
        match self {
            Self::Tip(..) => "glide on".to_owned(),
            Self::Probe(..) => sounded_words(heard),
        }
    }
}

/// What is said of a way while it goes on.
pub(super) struct Advice<'a> {
    pub(super) bone: &'a Bone,
    pub(super) asked: &'a Asked,
    pub(super) way: &'a Way<'a>,
    /// The name of the points' frame, for the file.
    pub(super) frame: &'a str,
}

impl Advice<'_> {
    /// What the points so far still lack.
    pub(super) fn lacks(&self, heard: &Listened) -> Lacks {
        Lacks {
            words: self.words(heard).unwrap_or_else(|why| why.to_string()),
            motion: None,
        }
    }

    fn words(&self, heard: &Listened) -> Result<String, SurfaceCommandError> {
        let Taken { text, count, refused } = self.way.taken(heard, self.frame);
        let left = refused.map_or_else(String::new, |refused| format!(". {refused}"));
        if count < ADVISED {
            return Ok(format!("{count} points; {}{left}", self.way.go_on(heard)));
        }
        // By the very way of the result: what is told meanwhile has the errors that points share, and its conditions.
        let source = Source::from_bytes(&self.asked.points, text.into_bytes()).map_err(TableError::from)?;
        let mut made = make(self.bone, self.asked, source)?;
        // As long again as the registration itself: only where nothing else is left to say.
        if made.against().is_empty() {
            made.look_for_a_mirror();
        }
        let tre = made.targets.iter().map(|target| made.found.predicted_tre_mm(*target));
        let worst = tre.fold(0.0, f64::max);
        let verdict = match made.against().first() {
            None => {
                let unknown = made.found.order.why_not();
                let unknown = unknown.map_or("", |_| " (whether the bone moved cannot be told yet)");
                format!("{count} points, nothing speaks against it{unknown}; {worst:.1} mm at the targets")
            }
            Some(refusal) => format!("{count} points, not yet: {refusal}"),
        };
        let variances = made
            .measured
            .points
            .points()
            .iter()
            .map(|point| point.covariance_mm2.trace() / 3.0);
        let touches = Touches {
            points: MORE,
            sigma_mm: (variances.sum::<f64>() / count as f64)
                .sqrt()
                .hypot(self.asked.options.priors.bone_mm),
            apart_mm: APART_MM,
            places: 2,
        };
        let places = next(&self.bone.surface, &made.found, &made.targets, &touches);
        let words: Vec<String> = places
            .iter()
            .map(|place| place_words(place.place_mm, place.normal, place.tre_mm))
            .collect();
        Ok(format!("{verdict}. More helps most {}{left}", words.join(", or ")))
    }
}

/// `near R 110 A 20 S 130, from L: 0.6 mm`.
fn place_words([x, y, z]: [f64; 3], normal: [f64; 3], tre_mm: f64) -> String {
    let place = Point::<Ct>::new(x, y, z).in_words(0);
    let side = Vector3::from(normal);
    let side: Option<Direction<Ct>> = geometry::Vector::new(side.x, side.y, side.z).direction();
    let from = side.map_or_else(String::new, |side| format!(", from {}", letters(side)));
    format!("near {place}{from}: then {tre_mm:.1} mm")
}
