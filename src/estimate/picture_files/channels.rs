//! A picture's channels by name, and the layers that they make up.

use super::layers::{LayerRow, NOTHING_SEEN, RADIANCE_UNIT};
use super::{PictureFileError, PictureLayer};
use crate::estimate::Picture;

/// What users call the brightness of a picture itself.
pub const LUMINANCE: &str = "luminance";
/// Of linear Rec. 709 (ITU-R BT.709).
const LUMINANCE_WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Everything that an EXR file holds of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channels {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Names (`R`, `radius.Y`) and values: row-major, top row first.
    pub named: Vec<(String, Vec<f32>)>,
}

/// One value a pixel, to look at.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerValues {
    /// What was asked for.
    pub name: String,
    /// What it holds; empty where that is not known.
    pub meaning: &'static str,
    /// Its unit; empty where there is none or it is not known.
    pub unit: &'static str,
    /// Row-major, top row first; NaN where the layer says that there is nothing.
    pub values: Vec<f32>,
}

impl Channels {
    /// Those of a picture and its layers.
    pub fn of(picture: &Picture, layers: &[PictureLayer]) -> Result<Self, PictureFileError> {
        let color = |index: usize| picture.radiance.iter().map(|pixel| pixel[index]).collect();
        let mut named: Vec<(String, Vec<f32>)> =
            ["R", "G", "B"].iter().enumerate().map(|(index, name)| ((*name).to_owned(), color(index))).collect();
        for layer in layers {
            let (names, values) = (layer.channel_names(), &layer.channels);
            if values.len() != names.len() {
                let name = layer.layer.row().name;
                let problem = format!("layer {name} has {} channels where {} belong", values.len(), names.len());
                return Err(PictureFileError::Encode { problem });
            }
            named.extend(names.into_iter().zip(values.iter().cloned()));
        }
        Ok(Self { width: picture.width, height: picture.height, named })
    }

    /// The values of a channel (`normal.X`), of a layer that has one channel (`radius`), or the luminance of a layer of red, green and
    /// blue (`albedo`, and [`LUMINANCE`] for the picture itself).
    pub fn layer(&self, name: &str) -> Result<LayerValues, PictureFileError> {
        let values = self.channel(name).map(<[f32]>::to_vec).or_else(|| self.brightness(name));
        let mut values = values.ok_or_else(|| {
            let (name, known) = (name.to_owned(), self.layer_names().join(", "));
            PictureFileError::UnknownLayer { name, known }
        })?;
        let row = LayerRow::named(name);
        let is_radiance = [LUMINANCE, "R", "G", "B"].contains(&name);
        let (meaning, unit) = match row {
            Some(row) => (row.meaning, row.unit),
            None if is_radiance => ("of the picture itself", RADIANCE_UNIT),
            None => ("", ""),
        };
        if row.is_some_and(|row| row.name == "depth") {
            values.iter_mut().filter(|depth| **depth >= NOTHING_SEEN).for_each(|depth| *depth = f32::NAN);
        }
        Ok(LayerValues { name: name.to_owned(), meaning, unit, values })
    }

    /// The names that [`Channels::layer`] knows.
    pub fn layer_names(&self) -> Vec<String> {
        let mut names = Vec::new();
        for (channel, _) in &self.named {
            let layer = channel.rsplit_once('.').map_or(LUMINANCE, |(layer, _)| layer);
            let name = if self.brightness(layer).is_some() { layer } else { channel };
            if !names.iter().any(|known| known == name) {
                names.push(name.to_owned());
            }
        }
        names
    }

    fn channel(&self, name: &str) -> Option<&[f32]> {
        self.named.iter().find(|(channel, _)| channel == name).map(|(_, values)| values.as_slice())
    }

    /// The only channel of a layer, or the luminance of its three colors.
    fn brightness(&self, layer: &str) -> Option<Vec<f32>> {
        if LayerRow::named(&format!("{layer}.R")).is_some_and(|row| row.layer.is_matte()) {
            return None;
        }
        let prefix = if layer == LUMINANCE { String::new() } else { format!("{layer}.") };
        let colors = ["R", "G", "B"].map(|color| self.channel(&format!("{prefix}{color}")));
        if let [Some(red), Some(green), Some(blue)] = colors {
            let luminance = |((red, green), blue): ((&f32, &f32), &f32)| {
                let [r, g, b] = LUMINANCE_WEIGHTS;
                r * red + g * green + b * blue
            };
            return Some(red.iter().zip(green).zip(blue).map(luminance).collect());
        }
        if prefix.is_empty() {
            return self.channel("Y").map(<[f32]>::to_vec);
        }
        let mut members = self.named.iter().filter(|(channel, _)| channel.starts_with(&prefix));
        members.next().filter(|_| members.next().is_none()).map(|(_, values)| values.clone())
    }
}
