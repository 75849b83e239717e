//! What is measured of one mesh.

/// One mesh: a line of the table and of the CSV file.
#[derive(Clone, Debug)]
pub struct Figure {
    pub scene: String,
    pub mesher: String,
    pub setting: String,
    pub seconds: f64,
    pub deviation: f64,
    pub volume_error: f64,
    pub triangles: usize,
}

impl Figure {
    pub fn columns(&self) -> [String; 7] {
        [
            self.scene.clone(),
            self.mesher.clone(),
            self.setting.clone(),
            format!("{:.3e}", self.seconds),
            format!("{:.2e}", self.deviation),
            format!("{:.2e}", self.volume_error),
            self.triangles.to_string(),
        ]
    }

    pub fn parse(line: &str) -> Option<Self> {
        let columns: Vec<&str> = line.split(',').collect();
        let &[
            scene,
            mesher,
            setting,
            seconds,
            deviation,
            volume,
            triangles,
        ] = &columns[..]
        else {
            return None;
        };
        Some(Self {
            scene: scene.to_owned(),
            mesher: mesher.to_owned(),
            setting: setting.to_owned(),
            seconds: seconds.parse().ok()?,
            deviation: deviation.parse().ok()?,
            volume_error: volume.parse().ok()?,
            triangles: triangles.parse().ok()?,
        })
    }
}
