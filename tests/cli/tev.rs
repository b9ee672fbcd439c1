//! Pictures in the viewer tev, whose end of the connection is played here.

use std::collections::BTreeMap;
use std::io::Read;
use std::net::TcpListener;
use std::thread::{self, JoinHandle};

use crate::command_line::{ended, program, run, success, text};
use crate::exr_channels::exr_channels;

const SCENE: &str = "tests/references/cornell-diffuse/scene.xml";

/// A picture as tev would have it.
#[derive(Default)]
struct Shown {
    name: String,
    size: [usize; 2],
    channels: BTreeMap<String, Vec<f32>>,
    creations: usize,
    updates: usize,
}

/// Reads the parts of a packet one after the other.
struct Packet<'a>(&'a [u8]);

impl Packet<'_> {
    fn byte(&mut self) -> u8 {
        let (byte, rest) = self.0.split_first().expect("a byte");
        self.0 = rest;
        *byte
    }

    fn four(&mut self) -> [u8; 4] {
        let (four, rest) = self.0.split_first_chunk().expect("four bytes");
        self.0 = rest;
        *four
    }

    fn number(&mut self) -> usize {
        usize::try_from(i32::from_le_bytes(self.four())).expect("not negative")
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).expect("a zero at the end");
        let text = String::from_utf8(self.0[..end].to_vec()).expect("UTF-8");
        self.0 = &self.0[end + 1..];
        text
    }
}

impl Shown {
    /// Does what a packet says, which stands here without its length.
    fn take(&mut self, mut packet: Packet<'_>) {
        let kind = packet.byte();
        let grabs_focus = packet.byte();
        let name = packet.text();
        match kind {
            4 => {
                self.size = [packet.number(), packet.number()];
                let count = packet.number();
                let black = vec![0.0; self.size[0] * self.size[1]];
                self.channels = (0..count).map(|_| (packet.text(), black.clone())).collect();
                self.name = name;
                self.creations += 1;
                assert_eq!(grabs_focus, 1);
            }
            5 => {
                assert_eq!((name, grabs_focus), (self.name.clone(), 0));
                let count = packet.number();
                let names: Vec<String> = (0..count).map(|_| packet.text()).collect();
                let [left, top, width, height] = [(); 4].map(|()| packet.number());
                for name in &names {
                    let channel = self.channels.get_mut(name).expect("a channel that was created");
                    for pixel in 0..width * height {
                        let at = (top + pixel / width) * self.size[0] + left + pixel % width;
                        channel[at] = f32::from_le_bytes(packet.four());
                    }
                }
                self.updates += 1;
            }
            other => panic!("a packet of kind {other}"),
        }
        assert!(packet.0.is_empty(), "{} bytes are left of a packet of kind {kind}", packet.0.len());
    }
}

/// An address where one connection is taken, and what it showed in the end.
fn viewer() -> (String, JoinHandle<Shown>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    let viewer = thread::spawn(move || {
        let mut received = Vec::new();
        listener.accept().expect("a connection").0.read_to_end(&mut received).expect("all of it");
        let (mut shown, mut left) = (Shown::default(), received.as_slice());
        while let Some((length, _)) = left.split_first_chunk() {
            let (packet, rest) = left.split_at(u32::from_le_bytes(*length) as usize);
            shown.take(Packet(&packet[4..]));
            left = rest;
        }
        shown
    });
    (address, viewer)
}

#[test]
fn tev_shows_what_the_file_holds() {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("room.exr");
    let (address, viewer) = viewer();
    // More rows than one packet carries, and an odd width.
    let job = ["render", SCENE, "--size", "37x150", "--method", "path", "--passes", "64", "--threads", "1"];
    let options = ["--layers", "error,depth", "--tev", &address, "-o", text(&picture)];
    success(&[job.as_slice(), &options].concat());
    let shown = viewer.join().expect("packets that tev understands");
    assert_eq!((shown.name.as_str(), shown.size, shown.creations), ("cornell-diffuse", [37, 150], 1));
    assert!(shown.updates >= 3, "{} updates", shown.updates);
    let expected = exr_channels(&std::fs::read(&picture).expect("a picture"));
    assert_eq!(shown.channels.len(), 5);
    assert!(expected.keys().eq(shown.channels.keys()));
    for (name, values) in &expected {
        let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert!(bits(values) == bits(&shown.channels[name]), "channel {name} differs");
    }
}

/// What is only shown never costs the picture.
#[test]
fn a_render_goes_on_without_tev() {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("a.exr");
    let render = |address: &str| {
        let job = ["render", SCENE, "--size", "64", "--method", "path", "--seconds", "3", "--threads", "1"];
        success(&[job.as_slice(), &["--overwrite", "--tev", address, "-o", text(&picture)]].concat())
    };
    let warnings = |told: &str| told.matches("no longer shows the picture").count();
    let told = render("127.0.0.1:9");
    assert!(warnings(&told) == 1 && told.contains("wrote "), "{told}");
    // One that closes the connection at once.
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    let leaving = thread::spawn(move || drop(listener.accept().expect("a connection")));
    let told = render(&address);
    leaving.join().expect("it was reached");
    assert!(warnings(&told) == 1 && told.contains("wrote "), "{told}");
    ended(&run(&["render", SCENE, "--tev", "here"]), 2);
    let watch = program(&["watch", "job", "--tev", "127.0.0.1:port"]).output().expect("it starts");
    assert!(ended(&watch, 2).contains("write HOST:PORT"));
}
