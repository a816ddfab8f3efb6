//! The model that a scene and its label map describe: organs, what holds them, and the tube at its first touch.

mod bounds;
mod obstacle;

use nalgebra::Vector3;
use simulation::space::cells::Field;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{Springs, TubeContact};

use super::body::Body;
use super::hold::{self, Held, Overlap};
use super::labels::Labels;
use super::plan::{Organ, Plan};
use super::target::{self, Target};
use super::way::Way;
use crate::numbers::{Checked, invalid};
pub use obstacle::Obstacle;

/// The contact's stiffness beside Young's modulus over the side of the smallest cubes: it sets how fast pressures converge.
const CONTACT: f64 = 60.0;
/// The tube is put so little before the place where it first touches, mm.
const BEFORE: f64 = 1e-6;

/// What a scene describes. Places are in the label map's own axes.
#[derive(Debug)]
pub struct Model {
    /// Solids, fixed nodes, springs and the tube's contacts; unknowns are displacements of nodes, mm.
    pub system: System,
    /// Organs, in the order of the plan and of the system's solids.
    pub bodies: Vec<Body>,
    /// What holds them.
    pub held: Vec<Held>,
    /// What holds by springs, in no order: [`Held`] says which.
    pub springs: Vec<Springs>,
    /// What is rigid and keeps organs out, in the order of the plan's contacts and of the system's obstacles.
    pub obstacles: Vec<Obstacle>,
    /// The tube's.
    pub way: Way,
    /// How far the tip goes from the entry until it touches, mm.
    pub free: f64,
    /// Places of organs that are told.
    pub targets: Vec<Target>,
    /// Attachments that hold the same points.
    pub overlaps: Vec<Overlap>,
}

impl Model {
    /// The model with the tube where it first touches.
    ///
    /// # Errors
    /// [`scene::Invalid`] with the key of the first value that the label map does not agree with.
    pub fn new(plan: &Plan, labels: &Labels) -> Checked<Self> {
        let mut model = Self::without_tube(plan, labels)?;
        model.system.tubes = model.contacts(plan)?;
        Ok(model)
    }

    /// The same model without contacts of the tube. Points of surfaces are as near to one another as a tube along its way needs.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn without_tube(plan: &Plan, labels: &Labels) -> Checked<Self> {
        let way = Way {
            entry: labels.own(&plan.way.entry),
            direction: labels.own_direction(&plan.way.direction),
            ..plan.way
        };
        present(plan, labels)?;
        bounds::expected(plan, labels)?;
        let (mut bodies, mut unknowns) = (Vec::new(), 0);
        for k in 0..plan.organs.len() {
            let body = Body::new(k, plan, labels, &way)?;
            unknowns += body.mesh.unknowns();
            bounds::most(k, unknowns)?;
            bodies.push(body);
        }
        let contacts = plan.contacts.iter().enumerate();
        let obstacles = contacts.map(|(k, one)| Obstacle::new(k, one, plan, labels, &bodies[one.organ], way.stroke));
        let obstacles = obstacles.collect::<Checked<_>>()?;
        let mut model = Self::assembled(plan, labels, (way, None), bodies, obstacles)?;
        model.targets = target::all(plan, labels, &model.bodies)?;
        model.overlaps = hold::overlaps(plan, labels, &model.bodies);
        model.fine_enough(&model.contacts(plan)?)?;
        Ok(model)
    }

    /// Organs of these meshes with what holds them, without the tube, which first touches after `free` where that is known.
    fn assembled(
        plan: &Plan,
        labels: &Labels,
        (way, free): (Way, Option<f64>),
        bodies: Vec<Body>,
        obstacles: Vec<Obstacle>,
    ) -> Checked<Self> {
        let mut system = System::new();
        for (k, (body, organ)) in bodies.iter().zip(&plan.organs).enumerate() {
            let solid = Deformable::new(body.mesh.clone(), organ.material, Vector3::zeros());
            let solid =
                solid.map_err(|why| invalid(format!("organs.{k}.poisson"), why, "a ratio that its elements can do"))?;
            system.add(solid);
        }
        let free = match free {
            Some(free) => free,
            None => first_touch(&way, &bodies, &system)?,
        };
        let (held, springs) = hold::all(plan, labels, (&way, free), &bodies, &mut system)?;
        for (k, (obstacle, contact)) in obstacles.iter().zip(&plan.contacts).enumerate() {
            let stiffness = stiffness(&plan.organs[contact.organ]);
            let term = obstacle.term(&system.bodies, contact.organ, stiffness);
            let term = term.map_err(|why| invalid(format!("contacts.{k}"), why, "an organ that can be pressed"))?;
            system.obstacles.push(term);
        }
        Ok(Self {
            system,
            bodies,
            held,
            springs,
            obstacles,
            way,
            free,
            targets: Vec::new(),
            overlaps: Vec::new(),
        })
    }

    /// The same meshes and the same tube, where it is and with its pressures, with the numbers of another plan.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn changed(&self, plan: &Plan, labels: &Labels) -> Checked<Self> {
        let (bodies, obstacles) = (self.bodies.clone(), self.obstacles.clone());
        let mut model = Self::assembled(plan, labels, (self.way, Some(self.free)), bodies, obstacles)?;
        model.system.tubes.clone_from(&self.system.tubes);
        model.system.obstacles.clone_from(&self.system.obstacles);
        model.targets.clone_from(&self.targets);
        Ok(model)
    }

    /// Each organ with what holds it and what it slides along alone, without the tube: organs know nothing of one another.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn apart(&self, plan: &Plan, labels: &Labels) -> Checked<Vec<System>> {
        let alone = |k: usize| {
            let of = |organ: usize| organ == k;
            let obstacles = self.obstacles.iter().zip(&plan.contacts);
            let obstacles = obstacles.filter(|(_, contact)| of(contact.organ));
            let obstacles = obstacles.map(|(obstacle, _)| obstacle.clone()).collect();
            let bodies = vec![self.bodies[k].clone()];
            let made = Self::assembled(&plan.alone(k), labels, (self.way, Some(self.free)), bodies, obstacles)?;
            Ok(made.system)
        };
        (0..self.bodies.len()).map(alone).collect()
    }

    /// The same organs in cubes half as large with what holds them there, without the tube.
    ///
    /// # Errors
    /// In words: too many unknowns, no mesh, or as [`Self::new`].
    pub fn halved(&self, plan: &Plan, labels: &Labels) -> Result<Self, String> {
        let (mut bodies, mut unknowns) = (Vec::new(), 0);
        for (k, body) in self.bodies.iter().enumerate() {
            let finer = body.halved(k, plan, labels, &self.way).map_err(|why| why.to_string())?;
            unknowns += finer.mesh.unknowns();
            if unknowns > bounds::MOST {
                return Err(format!(
                    "cubes half as large have {unknowns} unknowns or more; at most {} are allowed",
                    bounds::MOST
                ));
            }
            bodies.push(finer);
        }
        let made = Self::assembled(
            plan,
            labels,
            (self.way, Some(self.free)),
            bodies,
            self.obstacles.clone(),
        );
        let mut model = made.map_err(|why| why.to_string())?;
        model.targets = target::all(plan, labels, &model.bodies).map_err(|why| why.to_string())?;
        Ok(model)
    }

    /// Unknowns: all, and those that may change.
    pub fn unknowns(&self) -> [usize; 2] {
        let free = self.system.fixed.iter().filter(|fixed| !**fixed).count();
        [self.system.fixed.len(), free]
    }

    /// The tube touches every organ, and nothing else.
    fn contacts(&self, plan: &Plan) -> Checked<Vec<TubeContact>> {
        let refused = |why: String| invalid("tube", why, "a tube that can touch the organs");
        let contact = |(k, organ): (usize, &Organ)| {
            let tube = self.way.tube(self.free).map_err(|why| refused(why.to_string()))?;
            let contact = TubeContact::new(&self.system.bodies, k, tube, stiffness(organ), |_, _| true);
            contact.map_err(|why| refused(why.to_string()))
        };
        plan.organs.iter().enumerate().map(contact).collect()
    }

    /// Points of the surface along the whole way must be near enough to one another for the tube.
    fn fine_enough(&self, tubes: &[TubeContact]) -> Checked<()> {
        let a = self.system.initial();
        for stroke in self.way.strokes() {
            for (k, contact) in tubes.iter().enumerate() {
                let mut moved = contact.clone();
                let tube = self.way.tube(self.free + stroke);
                moved.move_to(tube.map_err(|why| invalid("tube", why, "a tube"))?);
                let (gap, most) = (moved.widest_gap(&self.system.bodies, &a), moved.deepest());
                if gap > most {
                    let found = format!(
                        "points of the surface of {:?} that are {gap:.2} mm from the middle between them, {stroke} mm along the stroke",
                        self.bodies[k].name
                    );
                    let allowed = format!(
                        "at most {most:.2} mm, a quarter of the tube's diameter: smaller cubes there (side, levels, within)"
                    );
                    return Err(invalid(format!("organs.{k}.cubes"), found, allowed));
                }
            }
        }
        Ok(())
    }
}

/// Of an organ's contacts, N/mm^3.
fn stiffness(organ: &Organ) -> f64 {
    let side = organ.settings.side / f64::from(1_u32 << organ.settings.levels);
    CONTACT * organ.material.lame.young() / side
}

/// All labels that are named are in the map.
fn present(plan: &Plan, labels: &Labels) -> Checked<()> {
    let all = labels.all();
    let missing = |key: String, label: u16| {
        let some: Vec<String> = all.iter().take(40).map(u16::to_string).collect();
        let more = if all.len() > some.len() { ", ..." } else { "" };
        let allowed = format!("a label of the map: {}{more}", some.join(", "));
        invalid(key, format!("{label}, which no voxel has"), allowed)
    };
    for (k, organ) in plan.organs.iter().enumerate() {
        if !all.contains(&organ.label) {
            return Err(missing(format!("organs.{k}.label"), organ.label));
        }
    }
    for (k, rigid) in plan.rigid.iter().enumerate() {
        if let Some((i, label)) = rigid.labels.iter().enumerate().find(|(_, l)| !all.contains(l)) {
            return Err(missing(format!("rigid.{k}.labels.{i}"), *label));
        }
    }
    Ok(())
}

/// How far the tip goes until it first touches a point of a surface; refused where it starts in tissue, or meets none.
fn first_touch(way: &Way, bodies: &[Body], system: &System) -> Checked<f64> {
    let tube = way.tube(0.0).map_err(|why| invalid("tube", why, "a tube"))?;
    let a = system.initial();
    let reach = 2.0 * super::plan::LONGEST;
    let mut first = f64::INFINITY;
    for (k, body) in bodies.iter().enumerate() {
        let (solid, part) = (system.bodies.solid(k), system.bodies.part(k, &a));
        let starts = || {
            invalid(
                "tube.entry",
                format!("the tube starts inside {:?}", body.name),
                "a place from which the whole tube is outside all organs",
            )
        };
        for point in 0..solid.points() {
            let at = solid.point(part, point);
            if tube.signed_distance(&at).value <= 0.0 {
                return Err(starts());
            }
            // A tube that advances meets a point that stands as one that stands meets a point that comes.
            if let Some(part) = tube.first_touch(&at, &(-way.direction * reach)) {
                first = first.min(part * reach);
            }
        }
        // All of it may lie inside, away from the surface.
        if body.field.value(&way.middle(0.0)) < 0.0 {
            return Err(starts());
        }
    }
    // Between points of a surface a thin tube meets none of them, and is in the organ all the same.
    let entered = bodies.iter().position(|body| way.last(&body.field).is_finite());
    if let Some(k) = entered.filter(|_| !first.is_finite()) {
        let found = format!(
            "points of the surface of {:?} between which the tube goes in and meets none",
            bodies[k].name
        );
        return Err(invalid(
            format!("organs.{k}.cubes"),
            found,
            "smaller cubes there (side, levels, within), or a wider tube",
        ));
    }
    if !first.is_finite() {
        return Err(invalid(
            "tube",
            "a way on which the tube touches no organ",
            "an entry and a target or direction that lead to one",
        ));
    }
    Ok((first - BEFORE).max(0.0))
}
