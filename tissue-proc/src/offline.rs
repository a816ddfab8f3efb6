//! The organs of a scene for poses of no run: the answers that the process gives, and the same organs with other numbers of their tissue.

use bus::message::{TissueHeader, TissueMesh, ToolPose};
use geometry::{Ct, Point, Rigid, Tool, Vector, VolumeGrid};
use organs::{Labels, Model, Parsed, Plan, RawSpaceScene, Varied};
use scene::{Scene, TissueSpec};

pub use crate::anatomy::LoadLabels;
use crate::anatomy::{apart, frames, labels, meshes, placed, read};
use crate::errors::Errors;
use crate::live::{Answer, Live};
use crate::message::header;

type Cause = Box<dyn std::error::Error + Send + Sync>;

/// A scene's organs, meshed.
#[derive(Debug)]
pub struct Anatomist {
    scene: Scene,
    spec: TissueSpec,
    source: Parsed<RawSpaceScene>,
    plan: Plan,
    labels: Labels,
    model: Model,
    mesh: TissueMesh,
}

/// Organs that follow one tube from pose to pose.
#[derive(Debug)]
pub struct Organs {
    live: Live,
    errors: Errors,
    /// Poses so far.
    seq: u64,
}

impl Anatomist {
    /// Reads and meshes what a scene's `[tissue]` names, on voxels like these.
    ///
    /// # Errors
    /// What the process would refuse at its start, in its words; a scene without that table.
    pub fn new(scene: &Scene, grid: &VolumeGrid, load: LoadLabels) -> Result<Self, Cause> {
        let spec = scene.tissue.clone().ok_or("the scene has no table [tissue]")?;
        let (source, plan) = read((scene, &spec))?;
        let labels = labels((&source, &plan), (scene, grid), load)?;
        let model = Model::without_tube(&plan, &labels).map_err(|why| source.error_at(why))?;
        let (_, mesh) = meshes(&model.bodies, (placed(&labels)?, [0; 32]))?;
        Ok(Self {
            mesh,
            scene: scene.clone(),
            spec,
            source,
            plan,
            labels,
            model,
        })
    }

    /// How many numbers of the tissue have a standard deviation.
    pub fn uncertain(&self) -> usize {
        self.plan.uncertain().len()
    }

    /// The organs as the scene has them, with what its uncertain numbers do to its targets.
    ///
    /// # Errors
    /// What the process would refuse, in its words.
    pub fn organs(&self) -> Result<Organs, Cause> {
        let varied = Varied::all(&self.model, &self.plan, &self.labels).map_err(|why| self.source.error_at(why))?;
        self.made(&self.plan, varied)
    }

    /// The organs with each such number so many standard deviations above what the scene says, in order; numbers that are left out are as it
    /// says. Meshes, and so their errors, are the same for all.
    ///
    /// # Errors
    /// In words: numbers that no tissue has, or what the process would refuse.
    pub fn others(&self, deviations: &[f64]) -> Result<Organs, Cause> {
        let mut plan = self.plan.clone();
        for (of, by) in self.plan.uncertain().iter().zip(deviations) {
            let changed = plan.with(of, of.at(*by));
            plan = changed.ok_or_else(|| format!("{}: no tissue has {}", of.key, of.at(*by)))?;
        }
        self.made(&plan, Vec::new())
    }

    fn made(&self, plan: &Plan, varied: Vec<Varied>) -> Result<Organs, Cause> {
        let changed = self.model.changed(plan, &self.labels);
        let model = changed.map_err(|why| self.source.error_at(why))?;
        let systems = model.apart(plan, &self.labels);
        let systems = systems.map_err(|why| self.source.error_at(why))?;
        let bodies = &self.model.bodies;
        let names = bodies.iter().map(|body| body.name.clone()).collect();
        let apart = (apart(bodies, &self.spec)?, names);
        let live = Live::new(
            frames(model, systems, (&self.scene, &self.spec))?,
            self.mesh.ct_from_model,
            apart,
        );
        let targets = self.scene.targets.iter().map(|target| target.centre);
        Ok(Organs {
            errors: Errors::new(targets, (bodies, &self.mesh, &live), varied, self.spec.error_every),
            live,
            seq: 0,
        })
    }
}

impl Organs {
    /// Follows the tube to a pose that was captured then: what goes before the nodes in the message that the process would send.
    pub fn pose(&mut self, t_capture_ns: i64, ct_from_tool: Rigid<Ct, Tool>) -> TissueHeader {
        self.seq += 1;
        let answer = self.live.answer(ct_from_tool);
        let frame = match &answer {
            Answer::State(frame) => Some(frame),
            _ => None,
        };
        let sample = ToolPose {
            seq: self.seq,
            t_capture_ns,
            ..ToolPose::EMPTY
        };
        let header = header(&sample, (self.seq, [0; 32]), Some(&answer), &self.live);
        let header = self.errors.told(header, frame, &self.live);
        if let Some(frame) = frame {
            self.errors.find(&sample, frame, &mut self.live);
        }
        header
    }

    /// How far one of the scene's targets has been moved, mm; `None` of one in no organ, and of any other place.
    pub fn moved(&self, target: Point<Ct>) -> Option<Vector<Ct>> {
        let [x, y, z] = self.errors.moved(target, &self.live)?;
        Some(Vector::new(x, y, z))
    }
}
