//! The JSON that commands write, as schemas in the repository: see `schema/` beside `src/`.

use std::path::Path;

use schemars::{JsonSchema, Schema, schema_for};
use serde_json::Value;

use super::account::Account;
use super::compare::Comparison;
use super::exact::ExactAccount;
use super::info::Info;
use super::{drawing, merge, section, sweep};

/// Of `measure`: of the exact boundary, or of a mesh.
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code)]
enum Measure {
    Exact(Box<ExactAccount>),
    Mesh(Box<Account>),
}

/// `STEREOTOMY_WRITE_SCHEMA=1 cargo test -p cli schemas` writes them anew.
#[test]
fn schemas_are_those_in_the_repository() {
    let schemas = [
        ("mesh", schema_for!(Account)),
        ("measure", schema_for!(Measure)),
        ("section", schema_for!(section::Account)),
        ("drawing", schema_for!(drawing::Account)),
        ("info", schema_for!(Info)),
        ("compare", schema_for!(Comparison)),
        ("merge", schema_for!(merge::Account)),
        // (Of a table's columns.)
        (
            "sweep",
            Schema::try_from(sweep::table_schema()).expect("an object"),
        ),
    ];
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema");
    for (name, schema) in schemas {
        let path = folder.join(format!("{name}.json"));
        if std::env::var_os("STEREOTOMY_WRITE_SCHEMA").is_some() {
            let text = serde_json::to_string_pretty(&schema).expect("JSON") + "\n";
            std::fs::write(&path, text).expect("written");
        }
        let text = std::fs::read_to_string(&path).expect("a schema");
        let kept: Value = serde_json::from_str(&text).expect("JSON");
        let now = serde_json::to_value(&schema).expect("JSON");
        assert!(
            kept == now,
            "{} is not what `csg {name}` writes",
            path.display()
        );
    }
}
