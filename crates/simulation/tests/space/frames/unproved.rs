//! Rigid surfaces that were looked for round the organ only: what is not known of them is refused by `settle` and from frame to frame.

use std::sync::Arc;

use nalgebra::Vector3;
use simulation::space::cells::Ball;
use simulation::space::equilibrium::{NoEquilibrium, Tolerance, settle};
use simulation::space::frames::{Frames, Refused, Settings, State};
use simulation::space::level_set::{LevelSet, Unproved};
use simulation::space::system::System;
use simulation::space::term::{ObstacleContact, TubeContact};

use super::bone::{layer_on, on_top, pose, tube};
use crate::contact::obstacle::newton;

/// How far below the layer what is rigid ends, under the tube, mm.
const BELOW: f64 = 14.0;

/// The layer's underside.
fn under(_: &Vector3<f64>, n: &Vector3<f64>) -> bool {
    n.z < -0.5
}

/// What the layer comes to, and how far round it that was looked for with which ball, mm.
struct Rigid {
    ball: Ball,
    reach: f64,
    radius: f64,
}

impl Rigid {
    fn new(size: f64, reach: f64, radius: f64) -> Self {
        let centre = Vector3::new(3.0, -2.0, -BELOW - size);
        let ball = Ball { centre, radius: size };
        Self { ball, reach, radius }
    }

    /// A layer over it that nothing but springs at its sides holds: it goes down with the tube.
    fn system(&self) -> System {
        let mut system = layer_on(under, 0.0, 5e-5);
        let points: Vec<Vector3<f64>> = places(&system).map(|(at, _, _)| at).collect();
        let field = Arc::new(self.ball);
        let set = LevelSet::about(field, &points, self.reach, self.radius).unwrap();
        system.obstacles = vec![ObstacleContact::new(&system.bodies, 0, set, 0.01, under).unwrap()];
        system
    }
}

/// Points of the underside at rest, their areas and numbers.
fn places(system: &System) -> impl Iterator<Item = (Vector3<f64>, f64, usize)> {
    let solid = system.bodies.solid(0);
    let points = (0..solid.points()).map(|k| (solid.reference(k), k));
    points
        .filter(|((at, normal, _), _)| under(at, normal))
        .map(|((at, _, area), k)| (at, area, k))
}

/// The least that any point has left: of its distance from the ball, and of the way that was looked at, mm. Half of the way to the next point is three
/// quarters of the root of an area at least.
fn left(rigid: &Rigid, system: &System, a: &[f64]) -> [f64; 2] {
    places(system).fold([f64::INFINITY; 2], |[near, way], (from, area, k)| {
        let to = system.bodies.solid(0).point(a, k);
        let gap = 0.75 * area.sqrt();
        let distance = (to - rigid.ball.centre).norm() - rigid.ball.radius;
        [
            near.min(distance - gap),
            way.min(rigid.reach - (to - from).norm() - gap),
        ]
    })
}

/// Pushes by half a millimetre each until it is refused, frame by frame and by `settle`: both reasons, and what was left before them.
fn pushed(rigid: &Rigid) -> [(Unproved, [f64; 2]); 2] {
    let start = rigid.system();
    let a = start.initial();
    let mut frames = Frames::new(start, a, 0, tube(), Settings::default(), on_top).unwrap();
    let mut system = rigid.system();
    system
        .tubes
        .push(TubeContact::new(&system.bodies, 0, tube(), 0.02, on_top).unwrap());
    let (mut newton, mut a) = (newton(&system, 1e-9), system.initial());
    let depths = || (1..=60).map(|k| f64::from(k) / 2.0);
    let mut before = left(rigid, &system, &a);
    let framed = depths().find_map(|depth| match frames.frame(&pose(depth)).state {
        State::Refused(Refused::Unproved(why)) => Some((why, before)),
        state => {
            assert!(
                matches!(state, State::Settled | State::Approximate),
                "{depth}: {state:?}"
            );
            before = left(rigid, frames.system(), frames.state());
            None
        }
    });
    let mut before = left(rigid, &system, &a);
    let settled = depths().find_map(|depth| {
        system.tubes[0].move_to(tube().at(pose(depth)).unwrap());
        match settle(&mut system, &mut newton, &mut a, &Tolerance::default()) {
            Err(NoEquilibrium::Unproved(why)) => Some((why, before)),
            found => {
                assert!(found.is_ok(), "{depth}: {found:?}");
                before = left(rigid, &system, &a);
                None
            }
        }
    });
    [framed, settled].map(|found| found.expect("it goes 30 mm down, by far more than there is room for"))
}

/// How much nearer a push of half a millimetre can come, with as much again for gaps that are stretched, mm.
const ONE_PUSH: f64 = 1.0;

#[test]
fn tissue_that_comes_to_an_edge_thinner_than_its_ball_is_refused() {
    // A pin of 3 mm, which a ball of 6 mm does not fit in.
    let rigid = Rigid::new(3.0, 40.0, 6.0);
    // Boxes have a diagonal of half the ball's radius at most, and a foot is within one and a half of that of all that it stands for; twice that may be added.
    let most = ONE_PUSH + 2.0 * 1.5 * 0.5 * rigid.radius;
    let start = rigid.system();
    assert!(left(&rigid, &start, &start.initial())[0] > most);
    for (why, [near, _]) in pushed(&rigid) {
        assert!(matches!(why, Unproved::Edge { apart, gap } if apart <= gap), "{why:?}");
        assert!((0.0..most).contains(&near), "{near} {most}");
    }
}

#[test]
fn tissue_that_goes_farther_than_was_looked_is_refused() {
    // Smooth and thick: all that is missing is what was not looked at.
    for (why, [_, way]) in pushed(&Rigid::new(40.0, 7.0, 15.0)) {
        assert!(
            matches!(why, Unproved::Beyond { moved, reach: 7.0, gap } if moved + gap > 7.0),
            "{why:?}"
        );
        assert!((0.0..ONE_PUSH).contains(&way), "{way}");
    }
}
