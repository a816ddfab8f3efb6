//! What TX and BX say, both in the same types.

pub(crate) mod bx;
pub(crate) mod tx;

use crate::fields::Fields;
use crate::handle::Handle;
use crate::pose::Transform;
use crate::status::{HandleStatus, MarkerUse, PortStatus, SystemStatus, ToolInformation};
use crate::why::Why;

/// A reply to TX or BX. Parts that were not asked for are `None`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Polled {
    /// One for each handle.
    pub tools: Vec<PolledTool>,
    /// Passive markers of no tool: option 1000.
    pub strays: Option<Spots>,
    /// The device's own status.
    pub system: SystemStatus,
}

/// A handle of a reply to TX or BX.
#[derive(Debug, Clone, PartialEq)]
pub struct PolledTool {
    /// Which.
    pub handle: Handle,
    /// Whether a pose is there.
    pub status: HandleStatus,
    /// Option 0001, of a tool whose status is valid.
    pub transform: Option<Transform>,
    /// Option 0001, of a tool that is not disabled; of TX for all.
    pub port: Option<PortStatus>,
    /// Likewise: the number of the frame in which it was looked for.
    pub frame: Option<u32>,
    /// Option 0002.
    pub information: Option<Information>,
    /// Option 0004: the single stray marker of an active tool, where it is seen.
    pub single: Option<Single>,
    /// Option 0008: the tool's own markers.
    pub markers: Option<Spots>,
}

/// What option 0002 says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Information {
    /// Of the tool.
    pub tool: ToolInformation,
    /// Of its markers A to T.
    pub markers: [MarkerUse; 20],
}

/// A single stray marker (option 0004): its status, and its place where that is not 0 or missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Single {
    /// 1 valid, 2 missing, 8 out of volume.
    pub status: u8,
    /// Where, mm.
    pub place_mm: Option<[f64; 3]>,
}

/// Places of markers. Without option 0800 those out of volume are counted and have no place.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Spots(pub Vec<Spot>);

/// One of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Whether it is out of volume.
    pub out_of_volume: bool,
    /// Where, mm.
    pub place_mm: Option<[f64; 3]>,
}

impl PolledTool {
    /// A tool of which nothing more is known.
    pub const fn new(handle: Handle, status: HandleStatus) -> Self {
        Self {
            handle,
            status,
            transform: None,
            port: None,
            frame: None,
            information: None,
            single: None,
            markers: None,
        }
    }

    /// What is said of its pose. A pose whose port's status was not asked for is not known to be valid.
    pub fn why(&self) -> Why {
        let port = self.port.unwrap_or(PortStatus(0));
        let why = match (self.status, self.port) {
            (HandleStatus::MISSING, None) => Why::Missing,
            (status, _) => status.why(port),
        };
        let information = self
            .information
            .map_or(Why::Valid, |information| information.tool.why());
        match why {
            Why::Valid | Why::Missing if !information.is_valid() => information,
            why => why,
        }
    }
}

impl Single {
    /// What is said of it.
    pub fn why(self) -> Why {
        match self.status {
            1 => Why::Valid,
            0 | 2 => Why::Missing,
            8 => Why::OutOfVolume,
            code => Why::Unknown {
                field: "status of a single stray",
                code: code.into(),
            },
        }
    }
}

impl Polled {
    /// All of it, by name.
    pub fn fields(&self, reply: &str) -> Fields {
        let mut fields = Fields::default();
        fields.add("reply", reply);
        fields.add("system.status", self.system.0);
        fields.add("system.means", self.system.words().join(", "));
        for (number, tool) in self.tools.iter().enumerate() {
            tool.put(&mut fields, &format!("tools[{number}]"));
        }
        if let Some(strays) = &self.strays {
            strays.put(&mut fields, "strays");
        }
        fields
    }
}

impl PolledTool {
    fn put(&self, fields: &mut Fields, name: &str) {
        fields.add(format!("{name}.handle"), self.handle.to_string());
        fields.add(format!("{name}.status"), self.status.0);
        fields.add(format!("{name}.why"), self.why().to_string());
        if let Some(port) = self.port {
            fields.add(format!("{name}.port"), port.0);
        }
        if let Some(frame) = self.frame {
            fields.add(format!("{name}.frame"), frame);
        }
        if let Some(transform) = &self.transform {
            transform.put(fields, name);
        }
        if let Some(information) = self.information {
            fields.add(format!("{name}.information"), information.tool.0);
            fields.add(format!("{name}.face"), information.tool.face());
            let used = information.markers.map(|used| used.0.to_string()).join(" ");
            fields.add(format!("{name}.marker_use"), used);
        }
        if let Some(single) = self.single {
            fields.add(format!("{name}.single.why"), single.why().to_string());
            single
                .place_mm
                .iter()
                .for_each(|mm| fields.add(format!("{name}.single.mm"), &mm[..]));
        }
        if let Some(markers) = &self.markers {
            markers.put(fields, &format!("{name}.markers"));
        }
    }
}

impl Spots {
    fn put(&self, fields: &mut Fields, name: &str) {
        for (number, spot) in self.0.iter().enumerate() {
            let why = if spot.out_of_volume {
                Why::OutOfVolume
            } else {
                Why::Valid
            };
            fields.add(format!("{name}[{number}].why"), why.to_string());
            spot.place_mm
                .iter()
                .for_each(|mm| fields.add(format!("{name}[{number}].mm"), &mm[..]));
        }
    }
}

impl Transform {
    /// As it came.
    pub(crate) fn put(&self, fields: &mut Fields, name: &str) {
        fields.add(format!("{name}.q_wxyz"), &self.q[..]);
        fields.add(format!("{name}.mm"), &self.t_mm[..]);
        fields.add(format!("{name}.error_mm"), self.error_mm);
    }
}
