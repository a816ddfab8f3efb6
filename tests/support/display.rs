//! An X server in memory, and an eye on its screen.

#![allow(clippy::print_stdout, reason = "why something is skipped")]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use bus::run::RunContext;
use window::code::{Code, Grid, PROPERTY, Place, key};
use x11rb::connection::Connection as _;
use x11rb::protocol::xproto::{AtomEnum, ConnectionExt as _, ImageFormat};
use x11rb::rust_connection::RustConnection;

/// A display in memory; gone when dropped.
pub(crate) struct Display {
    pub(crate) server: Child,
    pub(crate) name: String,
    pub(crate) eye: RustConnection,
    pub(crate) root: u32,
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Display {
    /// `None`, with a word, where there is no Xvfb.
    pub(crate) fn new(size: [u32; 2]) -> Option<Self> {
        if !Path::new("/usr/bin/Xvfb").exists() {
            println!("skipped: there is no /usr/bin/Xvfb (Debian: xvfb)");
            return None;
        }
        #[allow(
            clippy::disallowed_methods,
            reason = "a server of others, which this test alone uses"
        )]
        let mut server = Command::new("/usr/bin/Xvfb")
            .args(["-displayfd", "1", "-nolisten", "tcp", "-screen", "0"])
            .arg(format!("{}x{}x24", size[0], size[1]))
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap())
            .read_line(&mut number)
            .unwrap();
        let name = format!(":{}", number.trim());
        let (eye, screen) = RustConnection::connect(Some(&name)).unwrap();
        let root = eye.setup().roots[screen].root;
        Some(Self {
            server,
            name,
            eye,
            root,
        })
    }

    /// Where the coded cell is said to lie.
    pub(crate) fn place(&self) -> Option<Place> {
        let property = self
            .eye
            .intern_atom(false, PROPERTY.as_bytes())
            .ok()?
            .reply()
            .ok()?
            .atom;
        let tree = self.eye.query_tree(self.root).ok()?.reply().ok()?;
        tree.children.into_iter().find_map(|window| {
            let asked = self
                .eye
                .get_property(false, window, property, AtomEnum::CARDINAL, 0, 16)
                .ok()?;
            let cardinals: Vec<u32> = asked.reply().ok()?.value32()?.collect();
            Place::of_cardinals(&cardinals).ok()
        })
    }

    /// The coded cell as it stands on the screen, where it can be read.
    pub(crate) fn code(&self, run: &RunContext) -> Option<(Code, u32)> {
        self.code_at(self.place()?, run)
    }

    /// The same where the cell is known to lie.
    pub(crate) fn code_at(&self, place: Place, run: &RunContext) -> Option<(Code, u32)> {
        let [width, height] = place.size().map(|n| n as u16);
        let [x, y] = place.at.map(|n| n as i16);
        let asked = self
            .eye
            .get_image(ImageFormat::Z_PIXMAP, self.root, x, y, width, height, !0)
            .ok()?;
        let pixels = asked.reply().ok()?.data;
        let code = Grid::read(&pixels, place.square, key(run.epoch_ns)).ok()?;
        Some((code, place.pid))
    }
}
