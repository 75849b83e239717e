//! Profiles that are stored and read back, bit for bit.

use super::{Profile, Shape, Step};

impl From<Profile> for Vec<Step> {
    fn from(profile: Profile) -> Self {
        profile.steps
    }
}

/// Steps that leave one value, over maps and contours as functions make them.
impl TryFrom<Vec<Step>> for Profile {
    type Error = &'static str;

    fn try_from(steps: Vec<Step>) -> Result<Self, Self::Error> {
        let mut values = 0usize;
        for step in &steps {
            match step {
                Step::Shape(shape, map) => {
                    if !(map.is_finite() && map.matrix2.determinant() != 0.0) {
                        return Err("a map of a stored profile is not finite or singular");
                    }
                    if let Shape::Contours(contours, _) = shape
                        && contours.iter().any(|contour| contour.len() < 2)
                    {
                        return Err("a contour of a stored profile has fewer than two corners");
                    }
                }
                Step::Combine(_, count) => {
                    values = values
                        .checked_sub(*count)
                        .ok_or("a stored profile combines more values than it has")?;
                }
                Step::Fault(_) => return Err("a stored profile cannot be at fault"),
            }
            values += 1;
        }
        if values == 1 {
            Ok(Self { steps })
        } else {
            Err("a stored profile leaves none or several values")
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine2;

    use super::super::{Combination, FillRule, Path};
    use super::*;

    #[test]
    fn profiles_come_back_as_they_were() {
        let door = Path::from([0.0, 0.0])
            .line_to([2.0, 0.0])
            .arc_through([1.0, 1.7], [0.0, 0.1])
            .close();
        let profile = (door - Profile::circle(0.3).translate([1.0, 0.7]))
            | Profile::polygon([[0.1, 0.0], [7.0, 1e-300], [1.0 / 3.0, 2.0]]);
        for profile in [profile, Profile::empty()] {
            let steps = Vec::from(profile.clone());
            assert_eq!(Profile::try_from(steps), Ok(profile));
        }
    }

    #[test]
    fn faults_are_told_and_not_stored() {
        let faulty = Profile::circle(1.0) - Profile::circle(-1.0).translate([1.0, 0.0]);
        let told = faulty.fault().map(ToString::to_string);
        assert!(told.is_some_and(|fault| fault.starts_with("a radius is -1")));
        assert!(Profile::try_from(Vec::from(faulty)).is_err());
        assert_eq!(Profile::circle(1.0).fault(), None);
    }

    #[test]
    fn steps_that_no_function_makes_are_refused() {
        let disc = || Step::Shape(Shape::Disc, DAffine2::IDENTITY);
        let flat = DAffine2::from_scale([1.0, 0.0].into());
        let lone = Shape::Contours([vec![]].into(), FillRule::EvenOdd);
        for steps in [
            vec![],
            vec![disc(), disc()],
            vec![disc(), Step::Combine(Combination::Union, 2)],
            vec![Step::Shape(Shape::Disc, flat)],
            vec![Step::Shape(lone, DAffine2::IDENTITY)],
        ] {
            assert!(Profile::try_from(steps.clone()).is_err(), "{steps:?}");
        }
    }
}
