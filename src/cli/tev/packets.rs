//! What tev is told, as it reads it from a TCP connection (`src/Ipc.cpp` in github.com/Tom94/tev).
//!
//! A packet is its length in bytes (u32, the length itself included), its kind (u8), whether the picture comes to the front (u8), the picture's
//! name, and what belongs to the kind. Numbers are little-endian, texts end with a zero.

use std::ops::Range;

use crate::estimate::picture_files::Channels;

/// A new, black picture.
const CREATE_IMAGE: u8 = 4;
/// Values of several channels of a part of it, one channel after the other. tev calls this its second version; the third may interleave channels.
const UPDATE_IMAGE: u8 = 5;

/// Makes a picture of the size and with the channels of `channels`, and brings it to the front.
pub(super) fn create_image(name: &str, channels: &Channels) -> Vec<u8> {
    let mut packet = Packet::new(CREATE_IMAGE, true, name);
    packet.number(channels.width);
    packet.number(channels.height);
    packet.channel_names(channels);
    packet.finish()
}

/// Sets the values of some rows.
pub(super) fn update_rows(name: &str, channels: &Channels, rows: Range<u32>) -> Vec<u8> {
    let mut packet = Packet::new(UPDATE_IMAGE, false, name);
    packet.channel_names(channels);
    for number in [0, rows.start, channels.width, rows.end - rows.start] {
        packet.number(number);
    }
    for (_, values) in &channels.named {
        for value in &values[pixels_of(channels, &rows)] {
            packet.bytes.extend(value.to_le_bytes());
        }
    }
    packet.finish()
}

/// Where the pixels of these rows are among a channel's values.
pub(super) fn pixels_of(channels: &Channels, rows: &Range<u32>) -> Range<usize> {
    let [start, end] = [rows.start, rows.end].map(|row| row as usize * channels.width as usize);
    start..end
}

/// A packet that is being written.
struct Packet {
    bytes: Vec<u8>,
}

impl Packet {
    fn new(kind: u8, grabs_focus: bool, name: &str) -> Self {
        let mut packet = Self { bytes: vec![0, 0, 0, 0, kind, u8::from(grabs_focus)] };
        packet.text(name);
        packet
    }

    /// tev's are signed; sizes of pictures are far below where that shows.
    fn number(&mut self, number: u32) {
        self.bytes.extend(number.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.bytes.extend(text.bytes().filter(|byte| *byte != 0));
        self.bytes.push(0);
    }

    fn channel_names(&mut self, channels: &Channels) {
        self.number(channels.named.len() as u32);
        for (name, _) in &channels.named {
            self.text(name);
        }
    }

    /// The packet with its length in front.
    fn finish(mut self) -> Vec<u8> {
        let length = self.bytes.len() as u32;
        self.bytes[..4].copy_from_slice(&length.to_le_bytes());
        self.bytes
    }
}
