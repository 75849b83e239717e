//! What a file says around its geometry: schema, product, units, and colours.

use csg::brep::Face;
use csg::{Color, LengthUnit};
use rustc_hash::FxHashMap;

use super::text::{Entities, Id, List, Quoted, Real, Reals};
use super::{StepOptions, StepSchema};

/// The header section.
pub(super) fn header(options: &StepOptions) -> String {
    let name = Quoted(&options.name);
    let (description, schema) = match options.schema {
        StepSchema::Ap242 => (
            "managed model based 3d engineering",
            "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }",
        ),
        StepSchema::Ap214 => (
            "automotive design",
            "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }",
        ),
    };
    // The date is always the same, so that a file is the same whenever it is written.
    format!(
        "HEADER;\n\
         FILE_DESCRIPTION(('{description}'),'2;1');\n\
         FILE_NAME({name},'1970-01-01T00:00:00',(''),(''),'Stereotomy {}','Stereotomy','');\n\
         FILE_SCHEMA(('{schema}'));\n\
         ENDSEC;\n",
        env!("CARGO_PKG_VERSION")
    )
}

/// The units of all numbers, and how near points are to what they should be on.
pub(super) fn context(to: &mut Entities, unit: LengthUnit, uncertainty: f64) -> Id {
    let metric = |to: &mut Entities, prefix: &str| {
        to.share(format_args!(
            "(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({prefix},.METRE.))"
        ))
    };
    let length = match unit {
        LengthUnit::Micrometre => metric(to, ".MICRO."),
        LengthUnit::Millimetre => metric(to, ".MILLI."),
        LengthUnit::Centimetre => metric(to, ".CENTI."),
        LengthUnit::Metre => metric(to, "$"),
        LengthUnit::Inch => converted(to, "INCH", 25.4),
        LengthUnit::Foot => converted(to, "FOOT", 304.8),
    };
    let angle = to.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
    let solid_angle = to.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
    let uncertainty = Real(uncertainty);
    let uncertainty = to.add(format_args!(
        "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({uncertainty}),{length},\
         'distance_accuracy_value','')"
    ));
    to.add(format_args!(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)\
         GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({uncertainty}))\
         GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid_angle}))\
         REPRESENTATION_CONTEXT('',''))"
    ))
}

fn converted(to: &mut Entities, name: &str, millimetres: f64) -> Id {
    let dimension = to.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)");
    let metric = to.share("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
    let millimetres = Real(millimetres);
    let measure = to.add(format_args!(
        "LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({millimetres}),{metric})"
    ));
    to.add(format_args!(
        "(CONVERSION_BASED_UNIT('{name}',{measure})LENGTH_UNIT()NAMED_UNIT({dimension}))"
    ))
}

/// Writes products.
pub(super) struct Products {
    /// What they have in common.
    context: Id,
    of_product: Id,
    stage: Id,
}

/// A product with a shape.
#[derive(Clone, Copy)]
pub(super) struct Product {
    definition: Id,
    representation: Id,
}

impl Products {
    pub fn new(to: &mut Entities, schema: StepSchema, context: Id) -> Self {
        let (year, protocol) = match schema {
            StepSchema::Ap242 => (2014, "ap242_managed_model_based_3d_engineering"),
            StepSchema::Ap214 => (2000, "automotive_design"),
        };
        let application = to.add(format_args!(
            "APPLICATION_CONTEXT('{}')",
            protocol.replace('_', " ")
        ));
        to.add(format_args!(
            "APPLICATION_PROTOCOL_DEFINITION('international standard','{protocol}',{year},{application})"
        ));
        Self {
            context,
            of_product: to.add(format_args!(
                "PRODUCT_CONTEXT('',{application},'mechanical')"
            )),
            stage: to.add(format_args!(
                "PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')"
            )),
        }
    }

    /// A product whose shape is that of some bodies.
    pub fn of_bodies(&self, to: &mut Entities, name: &str, bodies: &[Id]) -> Product {
        self.product(to, (name, "ADVANCED_BREP_SHAPE_REPRESENTATION"), bodies)
    }

    /// A product that is put together from others, all of them where they are.
    pub fn of_products(&self, to: &mut Entities, name: &str, inner: &[Product]) -> Product {
        let whole = self.product(to, (name, "SHAPE_REPRESENTATION"), &[]);
        let origin = origin(to);
        for (number, part) in inner.iter().enumerate() {
            let (number, [outer, inner]) = (number + 1, [whole, *part]);
            let use_of = to.add(format_args!(
                "NEXT_ASSEMBLY_USAGE_OCCURRENCE('{number}','','',{},{},$)",
                outer.definition, inner.definition
            ));
            let shape = to.add(format_args!("PRODUCT_DEFINITION_SHAPE('','',{use_of})"));
            let place = to.add(format_args!(
                "ITEM_DEFINED_TRANSFORMATION('','',{origin},{origin})"
            ));
            let relation = to.add(format_args!(
                "(REPRESENTATION_RELATIONSHIP('','',{},{})\
                 REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({place})\
                 SHAPE_REPRESENTATION_RELATIONSHIP())",
                inner.representation, outer.representation
            ));
            to.add(format_args!(
                "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{shape})"
            ));
        }
        whole
    }

    fn product(&self, to: &mut Entities, (name, kind): (&str, &str), items: &[Id]) -> Product {
        let Self {
            context,
            of_product,
            stage,
        } = self;
        let name = Quoted(name);
        let product = to.add(format_args!("PRODUCT({name},{name},'',({of_product}))"));
        to.add(format_args!(
            "PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,({product}))"
        ));
        let formation = to.add(format_args!(
            "PRODUCT_DEFINITION_FORMATION('','',{product})"
        ));
        let definition = to.add(format_args!(
            "PRODUCT_DEFINITION('design','',{formation},{stage})"
        ));
        let shape = to.add(format_args!("PRODUCT_DEFINITION_SHAPE('','',{definition})"));
        let mut all = vec![origin(to)];
        all.extend(items);
        let items = List(&all);
        let representation = to.add(format_args!("{kind}({name},{items},{context})"));
        to.add(format_args!(
            "SHAPE_DEFINITION_REPRESENTATION({shape},{representation})"
        ));
        Product {
            definition,
            representation,
        }
    }
}

fn origin(to: &mut Entities) -> Id {
    to.placement(glam::DVec3::ZERO, [glam::DVec3::Z, glam::DVec3::X])
}

/// Colours for bodies and their faces.
pub(super) struct Styles {
    assignments: FxHashMap<[u32; 4], Id>,
    items: Vec<Id>,
}

impl Styles {
    pub fn new() -> Self {
        Self {
            assignments: FxHashMap::default(),
            items: Vec::new(),
        }
    }

    /// Gives a body its faces' colour, if they have one all, or else each face its own.
    pub fn paint(&mut self, to: &mut Entities, body: Id, faces: &[(Id, Face<'_>)]) {
        let color = |face: &Face<'_>| face.origin().color;
        let Some((_, first)) = faces.first() else {
            return;
        };
        let first = color(first);
        if faces.iter().all(|(_, face)| color(face) == first) {
            if let Some(color) = first {
                self.style(to, body, color);
            }
            return;
        }
        for (k, (id, face)) in faces.iter().enumerate() {
            // (Several may be written as one.)
            if k > 0 && faces[k - 1].0 == *id {
                continue;
            }
            if let Some(color) = color(face) {
                self.style(to, *id, color);
            }
        }
    }

    fn style(&mut self, to: &mut Entities, item: Id, color: Color) {
        let [r, g, b] = color.to_srgb();
        let key = [r, g, b, color.alpha].map(f32::to_bits);
        let assignment = *self
            .assignments
            .entry(key)
            .or_insert_with(|| assignment(to, color));
        let styled = to.add(format_args!("STYLED_ITEM('color',({assignment}),{item})"));
        self.items.push(styled);
    }

    /// Writes what holds them together.
    pub fn finish(self, to: &mut Entities, context: Id) {
        if !self.items.is_empty() {
            let items = List(&self.items);
            to.add(format_args!(
                "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{items},{context})"
            ));
        }
    }
}

fn assignment(to: &mut Entities, color: Color) -> Id {
    // In decimals that tell sixteen bits apart, as colours were given.
    let short = |x: f32| (f64::from(x) * 1e6).round() / 1e6;
    let rgb = color.to_srgb().map(short);
    let rgb = Reals(&rgb).to_string();
    let rgb = &rgb[1..rgb.len() - 1];
    let rgb = to.add(format_args!("COLOUR_RGB('',{rgb})"));
    let fill = to.add(format_args!("FILL_AREA_STYLE_COLOUR('',{rgb})"));
    let fill = to.add(format_args!("FILL_AREA_STYLE('',({fill}))"));
    let fill = to.add(format_args!("SURFACE_STYLE_FILL_AREA({fill})"));
    let mut styles = vec![fill];
    if color.alpha < 1.0 {
        let share = Real(1.0 - short(color.alpha));
        let clear = to.add(format_args!("SURFACE_STYLE_TRANSPARENT({share})"));
        styles.push(to.add(format_args!(
            "SURFACE_STYLE_RENDERING_WITH_PROPERTIES(.NORMAL_SHADING.,{rgb},({clear}))"
        )));
    }
    let styles = List(&styles);
    let side = to.add(format_args!("SURFACE_SIDE_STYLE('',{styles})"));
    let usage = to.add(format_args!("SURFACE_STYLE_USAGE(.BOTH.,{side})"));
    to.add(format_args!("PRESENTATION_STYLE_ASSIGNMENT(({usage}))"))
}
