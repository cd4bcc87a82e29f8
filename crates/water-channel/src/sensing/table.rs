//! Cameras and dots as they stand in a file.

use std::path::Path;

use serde::Deserialize;

use super::arrangement::Sensing;
use super::camera::{Camera, Region};
use super::dot::Dot;
use super::pose::Pose;
use super::viewer::Viewer;
use crate::error::FileError;
use crate::file;
use crate::quantity::{Direction, PixelEdge, PixelError, PixelSize, Place, Plain, Record, Samples, Seed};

/// Cameras and dots with the title and the provenance of every number of their file.
///
/// # The file
/// `title` and the section `[sensing]`, which a rig file may have too:
///
/// | key | unit (range) |
/// |---|---|
/// | `pixel_noise`, `quantization` | px (zero or more) |
/// | `delay` | samples (a whole number) |
/// | `seed` | a plain whole number (>= 0) |
/// | `[[sensing.camera]]`: `name` | text |
/// | `x`, `y`, `z`: the pinhole, upstream, right of it, down, from the centroid of the winch exits | m |
/// | `roll`, `pitch`, `heading`: the camera's axis is a nose | rad |
/// | `focal_length`, `width`, `height` | px (> 0) |
/// | `left`, `right`, `top`, `bottom`: region of interest; an edge left out is the image's | px (within the image) |
/// | `[[sensing.dot]]`: `x`, `y`, `z`: forward, starboard, down from the bridle joint | m |
/// | `normal_x`, `normal_y`, `normal_z`: outward normal along the body, zero where left out | 1 |
///
/// Numbers and units are those of [`RigFile`](crate::RigFile).
#[derive(Clone, Debug, PartialEq)]
pub struct SensingFile {
    /// The title of the file.
    pub title: String,
    /// Cameras and dots.
    pub sensing: Sensing,
    /// Every number as written, sorted by key.
    pub records: Vec<Record>,
}

impl SensingFile {
    /// Reads cameras and dots from a TOML file.
    ///
    /// # Errors
    /// [`FileError`], with the file, the key, what was found and what is allowed. Unknown keys are errors.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, FileError> {
        file::read(path.as_ref(), Self::parse)
    }

    /// Reads cameras and dots from the text of a TOML file; see [`SensingFile::read`].
    ///
    /// # Errors
    /// [`FileError`], without the name of a file.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        let (table, records) = file::parse::<FileTable>(text)?;
        let sensing = table.sensing.sensing();
        Viewer::new(&sensing, [0.0; 3]).map_err(FileError::Inconsistent)?;
        Ok(Self { title: table.title, sensing, records })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct FileTable {
    title: String,
    sensing: SensingTable,
}

/// The section of a rig file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct SensingTable {
    pixel_noise: PixelError,
    quantization: PixelError,
    delay: Samples,
    seed: Seed,
    #[serde(default)]
    camera: Vec<CameraTable>,
    #[serde(default)]
    dot: Vec<DotTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct CameraTable {
    name: String,
    x: Place,
    y: Place,
    z: Place,
    roll: Direction,
    pitch: Direction,
    heading: Direction,
    focal_length: PixelSize,
    width: PixelSize,
    height: PixelSize,
    left: Option<PixelEdge>,
    right: Option<PixelEdge>,
    top: Option<PixelEdge>,
    bottom: Option<PixelEdge>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct DotTable {
    x: Place,
    y: Place,
    z: Place,
    #[serde(default)]
    normal_x: Plain,
    #[serde(default)]
    normal_y: Plain,
    #[serde(default)]
    normal_z: Plain,
}

impl SensingTable {
    pub(crate) fn sensing(self) -> Sensing {
        Sensing {
            cameras: self.camera.into_iter().map(CameraTable::camera).collect(),
            dots: self.dot.iter().map(DotTable::dot).collect(),
            pixel_noise_px: self.pixel_noise.0,
            quantization_px: self.quantization.0,
            // Whole numbers that a double holds exactly: checked where they are read.
            delay_samples: self.delay.0 as usize,
            seed: self.seed.0,
        }
    }
}

impl CameraTable {
    fn camera(self) -> Camera {
        let (width_px, height_px) = (self.width.0, self.height.0);
        let whole = Region::whole(width_px, height_px);
        let edge = |edge: Option<PixelEdge>, of_image: f64| edge.map_or(of_image, |edge| edge.0);
        Camera {
            name: self.name,
            pose: Pose {
                position_m: [self.x.0, self.y.0, self.z.0],
                roll_rad: self.roll.0,
                pitch_rad: self.pitch.0,
                heading_rad: self.heading.0,
            },
            focal_length_px: self.focal_length.0,
            width_px,
            height_px,
            region: Region {
                left_px: edge(self.left, whole.left_px),
                right_px: edge(self.right, whole.right_px),
                top_px: edge(self.top, whole.top_px),
                bottom_px: edge(self.bottom, whole.bottom_px),
            },
        }
    }
}

impl DotTable {
    fn dot(&self) -> Dot {
        Dot { position_m: [self.x.0, self.y.0, self.z.0], normal: [self.normal_x.0, self.normal_y.0, self.normal_z.0] }
    }
}
