//! Charts of results: error against time, time to an error, the best method of each scene, a job's own estimate, and a report with all results;
//! and false-color maps of layers.
//!
//! A chart is first a [`Drawing`], a list of pictures, lines, areas and words; `canvas` makes SVG or PNG of it.

mod best_chart;
mod canvas;
mod color_scale;
mod drawing;
mod error_chart;
mod job_chart;
mod map_chart;
mod report;
mod scale;
mod style;
mod time_chart;

pub use canvas::{CanvasError, to_png, to_svg};
pub use color_scale::{ColorScale, ScaleError, ScaleRequest, Spacing};
pub use drawing::Drawing;
pub use job_chart::{JobPoint, draw_job};
pub use map_chart::{Map, MapSheet, draw_layer};
pub use report::{ReportError, report};

use super::curves::{Curve, curves};
use super::peers::PeerPoint;
use super::record::Record;
use super::sample::{Measure, Sample};
use style::CurveStyle;

/// The charts there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChartKind {
    /// Error against processor time, one panel a scene.
    #[default]
    Error,
    /// Processor time until an error is reached.
    Time,
    /// How much worse than the best each method is.
    Best,
}

impl ChartKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Error, Self::Time, Self::Best];

    /// The name that users write.
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Time => "time",
            Self::Best => "best",
        }
    }
}

/// What charts show.
pub struct ChartData {
    measure: Measure,
    target: f64,
    curves: Vec<Curve>,
    scenes: Vec<String>,
    /// Of each label, our own before peers.
    styles: Vec<(String, CurveStyle)>,
}

impl ChartData {
    /// Sums up results and other programs' points. `target` is the error of the time chart.
    pub fn new(records: &[Record], peers: &[PeerPoint], measure: Measure, target: f64) -> Self {
        let own = records.iter().map(|record| Sample::of(record, measure));
        let samples: Vec<Sample> = own.chain(peers.iter().filter_map(|point| point.sample(measure))).collect();
        let curves = curves(&samples, measure);
        let distinct = |name: &dyn Fn(&Curve) -> &String| {
            let mut names: Vec<String> = Vec::new();
            curves.iter().for_each(|curve| {
                if !names.contains(name(curve)) {
                    names.push(name(curve).clone());
                }
            });
            names
        };
        let scenes = distinct(&|curve| &curve.scene);
        let is_peer = |label: &String| curves.iter().any(|curve| curve.label == *label && curve.peer);
        let labels = distinct(&|curve| &curve.label);
        let styles = style::assign(labels.into_iter().map(|label| (is_peer(&label), label)));
        Self { measure, target, scenes, styles, curves }
    }

    /// One chart.
    pub fn draw(&self, kind: ChartKind) -> Drawing {
        match kind {
            ChartKind::Error => error_chart::draw(self),
            ChartKind::Time => time_chart::draw(self),
            ChartKind::Best => best_chart::draw(self),
        }
    }

    fn curve(&self, scene: &str, label: &str) -> Option<&Curve> {
        self.curves.iter().find(|curve| curve.scene == scene && curve.label == label)
    }

    fn of_scene<'a>(&'a self, scene: &'a str) -> impl Iterator<Item = &'a Curve> {
        self.curves.iter().filter(move |curve| curve.scene == scene)
    }

    fn style(&self, label: &str) -> CurveStyle {
        let known = self.styles.iter().find(|(name, _)| name == label);
        known.map_or_else(CurveStyle::default, |(_, style)| *style)
    }
}
