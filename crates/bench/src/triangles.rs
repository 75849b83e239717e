//! How many triangles does each mesher need for the deviation that it reaches,
//! and how many do we for the same?

use crate::figure::Figure;

/// Meshes nearer to the boundary than this are exact but for rounding.
const EXACT: f64 = 1e-8;

/// Prints a line for every mesh of another mesher: its triangles, ours at the
/// same measured deviation, and how many times as many that is. `figures` are
/// all of one scene.
pub fn print(figures: &[Figure]) {
    let (ours, others): (Vec<&Figure>, Vec<&Figure>) = figures
        .iter()
        .filter(|figure| figure.mesher != "ours uniform")
        .partition(|figure| figure.mesher == "ours");
    println!("\n| scene | mesher | setting | deviation | triangles | ours | ratio |");
    println!("|{}", " --- |".repeat(7));
    for other in others {
        let (count, ratio) = match triangles_at(other.deviation, &ours) {
            Some(count) => (
                format!("{count:.0}"),
                format!("{:.3}", count / other.triangles as f64),
            ),
            None => ("-".to_owned(), "-".to_owned()),
        };
        let Figure {
            scene,
            mesher,
            setting,
            deviation,
            triangles,
            ..
        } = other;
        println!(
            "| {scene} | {mesher} | {setting} | {deviation:.2e} | {triangles} | {count} | {ratio} |"
        );
    }
    println!();
}

/// Our triangles at a deviation, between two of our meshes by a power law; none
/// below the least deviation that we reached. At more than the largest one, the
/// fewest of all.
fn triangles_at(deviation: f64, ours: &[&Figure]) -> Option<f64> {
    let deviation = deviation.max(EXACT);
    let mut points: Vec<(f64, f64)> = ours
        .iter()
        .map(|figure| (figure.deviation.max(EXACT), figure.triangles as f64))
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let (first, last) = (points.first()?, points.last()?);
    if deviation < first.0 {
        return None;
    }
    if deviation >= last.0 {
        return Some(last.1);
    }
    let after = points.partition_point(|point| point.0 <= deviation);
    let ((low, many), (high, few)) = (points[after - 1], points[after]);
    let share = (deviation / low).ln() / (high / low).ln();
    Some(many * (few / many).powf(share))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_between_two_meshes_follow_a_power_law() {
        let figure = |deviation, triangles| Figure {
            scene: String::new(),
            mesher: "ours".to_owned(),
            setting: String::new(),
            seconds: 1.0,
            deviation,
            volume_error: 0.0,
            triangles,
        };
        let figures = [figure(1e-2, 100), figure(1e-4, 10_000), figure(1e-3, 1000)];
        let ours: Vec<&Figure> = figures.iter().collect();
        let at = |deviation| triangles_at(deviation, &ours);
        assert!((at(3e-3).expect("between") - 100.0 / 0.3).abs() < 1e-6);
        assert!((at(2e-4).expect("between") - 5000.0).abs() < 1e-6);
        assert_eq!((at(1e-5), at(1.0)), (None, Some(100.0)));
        let exact = [figure(1e-16, 12)];
        let ours: Vec<&Figure> = exact.iter().collect();
        assert_eq!(triangles_at(3e-15, &ours), Some(12.0));
    }
}
