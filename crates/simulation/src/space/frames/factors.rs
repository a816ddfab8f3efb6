//! The factor of the second derivatives without contact, a little old, and the thread that makes the next one.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use super::near::{Active, Near, Tissue};
use super::touch::Touches;
use crate::control::Potential;
use crate::space::system::System;
use crate::sparse::{Dissection, Ldl, Precision, Triplets};

/// A factor and the memory that it takes to make one.
#[derive(Debug)]
pub(super) struct Factor {
    pub(super) ldl: Ldl,
    /// The points at the tube, by this factor.
    pub(super) near: Arc<Near>,
    pub(super) active: Active,
    matrix: Triplets,
    /// False where the second derivatives are not positive definite, nor is a convex matrix near them.
    whole: bool,
}

impl Factor {
    fn new(order: Dissection, precision: Precision) -> Box<Self> {
        let mut ldl = Ldl::ordered_by(order);
        ldl.set_precision(precision);
        Box::new(Self {
            ldl,
            near: Arc::default(),
            active: Active::default(),
            matrix: Triplets::default(),
            whole: false,
        })
    }

    /// Factors the second derivatives at `a`: the true ones, or of solids of which they are not positive definite a convex matrix near theirs. What one
    /// solid needs is not done to the others, whose steps it would make slow.
    fn make(&mut self, system: &System, a: &[f64]) {
        (self.near, self.active) = (Arc::default(), Active::default());
        let mut convex = vec![false; system.bodies.len()];
        self.whole = loop {
            let is_definite = self.factored(system, a, &convex);
            let falling = (is_definite == Some(false))
                .then(|| self.ldl.falling_direction())
                .flatten();
            let more = match (is_definite, falling) {
                (Some(true), _) => break true,
                (Some(false), Some(direction)) => falls(system, &direction),
                // A pivot that vanishes has no direction.
                _ => vec![true; convex.len()],
            };
            if more.iter().zip(&convex).all(|(more, convex)| *convex || !more) {
                break false;
            }
            convex.iter_mut().zip(more).for_each(|(convex, more)| *convex |= more);
        };
    }

    /// Whether a matrix is definite, with its factor if so; `None` where there is none, or a pivot vanishes.
    fn factored(&mut self, system: &System, a: &[f64], convex: &[bool]) -> Option<bool> {
        system.hessian_where(a, convex, &mut self.matrix)?;
        hold(&mut self.matrix, system);
        self.ldl.take(&self.matrix);
        self.ldl.definite(0.0).ok()
    }

    /// Takes these points, in ascending order, as those at the tube; `pressing` are sure to be asked for.
    pub(super) fn serve(&mut self, touches: &Touches, points: Vec<usize>, pressing: &[usize]) {
        let tissue = Tissue {
            ldl: &self.ldl,
            touches,
        };
        // Blocks go by the numbers of points near; their columns stay.
        self.active.clear();
        for point in pressing {
            self.active.column(&tissue, *point);
        }
        // Once a factor: columns that are made for what is only told must not change what contact is measured by.
        let mean = match self.near.mean() {
            mean if mean > 0.0 => mean,
            _ => self.active.mean(&tissue, &points),
        };
        self.near = Arc::new(Near::new(points, mean));
    }
}

/// Leaves out unknowns that are held: they get a pivot in the scale of the others, so that none of them looks singular.
pub(super) fn hold(matrix: &mut Triplets, system: &System) {
    let scale = matrix.diagonal().into_iter().fold(f64::MIN_POSITIVE, f64::max);
    matrix.fix(system.fixed(), scale);
}

/// Which solids a direction moves.
fn falls(system: &System, direction: &[f64]) -> Vec<bool> {
    let moves = |body| system.bodies.part(body, direction).iter().any(|x| *x != 0.0);
    (0..system.bodies.len()).map(moves).collect()
}

/// Points at the tube, and those of them that press.
pub(super) type Points = (Vec<usize>, Vec<usize>);

/// A factor to be made, the state, and the points at the tube that it is to serve.
type Job = (Box<Factor>, Vec<f64>, Points);

/// A thread that makes factors one after the other.
#[derive(Debug)]
struct Worker {
    jobs: Option<Sender<Job>>,
    done: Receiver<Box<Factor>>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    fn new(system: Arc<System>, touches: Arc<Touches>) -> Self {
        let (jobs, inbox) = channel::<Job>();
        let (outbox, done) = channel();
        let work = move || {
            for (mut factor, a, (points, pressing)) in inbox {
                factor.make(&system, &a);
                if factor.whole {
                    factor.serve(&touches, points, &pressing);
                }
                if outbox.send(factor).is_err() {
                    break;
                }
            }
        };
        Self {
            jobs: Some(jobs),
            done,
            thread: Some(std::thread::spawn(work)),
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        // Without a sender the thread's loop ends.
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            // A panic there has been told; there is nobody left to tell.
            let _ = thread.join();
        }
    }
}

/// The factor in use, and the next.
#[derive(Debug)]
pub(super) struct Factors {
    pub(super) now: Box<Factor>,
    /// Which one that is, from 1.
    pub(super) number: u64,
    spare: Option<Box<Factor>>,
    worker: Option<Worker>,
    order: Dissection,
    touches: Arc<Touches>,
    precision: Precision,
    /// The frame in which the next one is taken up.
    due: Option<u64>,
}

impl Factors {
    /// The first factor; none where it cannot be made.
    pub(super) fn new(
        system: &Arc<System>,
        order: Dissection,
        touches: Arc<Touches>,
        precision: Precision,
        a: &[f64],
    ) -> Option<Self> {
        let mut now = Factor::new(order.clone(), precision);
        now.make(system, a);
        now.whole.then(|| Self {
            now,
            number: 1,
            spare: Some(Factor::new(order.clone(), precision)),
            worker: None,
            order,
            touches,
            precision,
            due: None,
        })
    }

    /// The order of elimination.
    pub(super) fn order(&self) -> &Dissection {
        &self.order
    }

    /// True while a next one is being made.
    pub(super) fn is_waiting(&self) -> bool {
        self.due.is_some()
    }

    /// Asks for the factor at `a`, with these points at the tube, to be taken up in frame `due` by [`Self::take_up`].
    pub(super) fn ask(&mut self, system: &Arc<System>, a: &[f64], points: Points, due: u64) {
        let Some(factor) = self.spare.take() else {
            return;
        };
        let new = || Worker::new(Arc::clone(system), Arc::clone(&self.touches));
        let worker = self.worker.get_or_insert_with(new);
        let sent = worker.jobs.as_ref().map(|jobs| jobs.send((factor, a.to_vec(), points)));
        if matches!(sent, Some(Ok(()))) {
            self.due = Some(due);
        }
    }

    /// In the frame that it is due in, waits for the next factor if need be and takes it up; true where that is so.
    pub(super) fn take_up(&mut self, frame: u64) -> bool {
        if self.due.is_none_or(|due| due > frame) {
            return false;
        }
        self.due = None;
        let Some(next) = self.worker.as_ref().and_then(|worker| worker.done.recv().ok()) else {
            // The thread is gone, and its memory with it: the next one begins anew.
            self.worker = None;
            self.spare = Some(Factor::new(self.order.clone(), self.precision));
            return false;
        };
        self.adopt(next)
    }

    /// Makes the factor at `a` at once; true where it is whole.
    pub(super) fn make_now(&mut self, system: &System, a: &[f64]) -> bool {
        let Some(mut next) = self.spare.take() else {
            return false;
        };
        next.make(system, a);
        self.adopt(next)
    }

    /// One that is not whole is left aside: the old one still serves.
    fn adopt(&mut self, next: Box<Factor>) -> bool {
        // The one that goes out of use is where the next is made: two are enough.
        let whole = next.whole;
        self.spare = Some(if whole {
            std::mem::replace(&mut self.now, next)
        } else {
            next
        });
        self.number += u64::from(whole);
        whole
    }
}
