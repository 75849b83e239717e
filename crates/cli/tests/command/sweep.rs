//! `csg sweep`, `csg completions` and `csg man`.

use std::fs;

use crate::{DRILLED_VOLUME, Folder, failed, succeeded};

/// Files of their own, a row each.
const TABLE: &str =
    "model,note\nin.csg,\"as it is, drilled\"\nball.csg,round\nbox.csg,\nbad.csg,\n";

fn folder() -> Folder {
    let folder = Folder::new();
    for (name, text) in [
        ("ball.csg", "sphere(r = 2);"),
        ("box.csg", "cube(size = [1, 2, 3], center = false);"),
        ("bad.csg", "roof();"),
        ("table.csv", TABLE),
    ] {
        fs::write(folder.file(name), text).expect("a file");
    }
    folder
}

#[test]
fn rows_are_measured_and_the_same_in_any_number_of_parts() {
    let folder = folder();
    let rows = |name: &str| -> Vec<String> {
        let text = fs::read_to_string(folder.file(name)).expect("a table");
        text.lines().map(str::to_owned).collect()
    };
    let whole = "sweep table.csv -o all.csv --write {row}.stl --write {row}.step";
    let message = failed(&folder.run(whole), 4);
    assert!(message.contains("1 of 4 variants failed"), "{message}");
    let all = rows("all.csv");
    assert_eq!(all.len(), 5);
    assert!(all[0].starts_with("row,model,note,volume,volume_error,area,"));
    let volume = |row: &str| -> f64 {
        row.split(',')
            .nth(3)
            .expect("a field")
            .parse()
            .expect("a number")
    };
    assert!(
        all[1].starts_with("1,in.csg,\"as it is, drilled\",0.98878955719"),
        "{}",
        all[1]
    );
    assert!((volume(&all[2]) - 32.0 / 3.0 * std::f64::consts::PI).abs() < 1e-9);
    assert!((volume(&all[3]) - 6.0).abs() < 1e-12);
    assert!(
        all[4].contains("roof") && all[4].contains(",,,,"),
        "{}",
        all[4]
    );
    for file in ["1.stl", "2.step", "3.stl"] {
        assert!(folder.file(file).exists(), "{file}");
    }
    let mesh = io::read_mesh(folder.file("1.stl")).expect("a mesh");
    assert!((mesh.volume() - DRILLED_VOLUME).abs() < 0.05);
    assert!(!folder.file("4.stl").exists());

    for parts in [2, 3, 7] {
        let mut joined = vec![all[0].clone()];
        for part in 1..=parts {
            let options =
                format!("--write {{row}}.stl --write {{row}}.step --shard {part}/{parts}");
            folder.run(&format!("sweep table.csv -o part.csv {options}"));
            let part = rows("part.csv");
            assert_eq!(part[0], all[0]);
            joined.extend_from_slice(&part[1..]);
        }
        assert_eq!(joined, all, "{parts} parts");
    }
}

#[test]
fn numbers_have_the_digits_that_are_known() {
    let folder = folder();
    let turned = "multmatrix([[6.123e-17, -0.9999999999999999, 0, 0], \
                  [0.9999999999999999, 6.123e-17, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) \
                  { cube(size = [1, 1, 1], center = false); }";
    fs::write(folder.file("turned.csg"), turned).expect("a file");
    fs::write(folder.file("one.csv"), "model\nturned.csg\n").expect("a file");
    succeeded(&folder.run("sweep one.csv -o out.csv"));
    let text = fs::read_to_string(folder.file("out.csv")).expect("a table");
    let fields: Vec<&str> = text.lines().nth(1).expect("a row").split(',').collect();
    assert_eq!(
        fields[5..14],
        [
            "-0.5", "0.5", "0.5", "-1.0", "0.0", "0.0", "0.0", "1.0", "1.0"
        ]
    );
    let [volume, error] = [2, 3].map(|k| fields[k].parse::<f64>().expect("a number"));
    assert!(error < 1e-12 && (volume - 1.0).abs() <= error, "{text}");
}

/// Every column of a table is told in the help.
#[test]
fn columns_are_described() {
    let folder = folder();
    fs::write(folder.file("one.csv"), "model\nball.csg\n").expect("a file");
    succeeded(&folder.run("sweep one.csv -o out.csv"));
    let help = folder.run("sweep --help");
    let help = String::from_utf8_lossy(&succeeded(&help).stdout).into_owned();
    let (_, help) = help.split_once("Columns of OUT").expect("columns");
    let text = fs::read_to_string(folder.file("out.csv")).expect("a table");
    let names = text.lines().next().expect("names").split(',');
    for name in names.filter(|name| *name != "model") {
        let is_told = help
            .lines()
            .any(|line| line.trim_start().starts_with(&format!("{name} ")));
        assert!(is_told, "{name}: {help}");
    }
}

#[cfg(feature = "parquet")]
#[test]
fn tables_are_written_as_parquet() {
    use parquet::basic::Type;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    let folder = folder();
    fs::write(
        folder.file("typed.csv"),
        "model,bore,note\nball.csg,0.50,\nbad.csg,,late\nbox.csg,2,3\n",
    )
    .expect("a file");
    failed(&folder.run("sweep typed.csv -o out.PARQUET"), 4);
    let file = fs::File::open(folder.file("out.PARQUET")).expect("a file");
    let reader = SerializedFileReader::new(file).expect("a table");
    let kinds: Vec<(String, Type)> = reader
        .metadata()
        .file_metadata()
        .schema_descr()
        .columns()
        .iter()
        .map(|column| (column.name().to_owned(), column.physical_type()))
        .collect();
    for (at, name, kind) in [
        (0, "row", Type::INT64),
        (1, "model", Type::BYTE_ARRAY),
        (2, "bore", Type::DOUBLE),
        (3, "note", Type::BYTE_ARRAY),
        (4, "volume", Type::DOUBLE),
        (17, "genus", Type::INT64),
        (20, "error", Type::BYTE_ARRAY),
    ] {
        assert_eq!(kinds[at], (name.to_owned(), kind));
    }
    let rows = reader.get_row_iter(None).expect("rows");
    let rows: Vec<Vec<Field>> = rows
        .map(|row| {
            let row = row.expect("a row");
            row.get_column_iter()
                .map(|(_, field)| field.clone())
                .collect()
        })
        .collect();
    assert_eq!(rows.len(), 3);
    let text = |text: &str| Field::Str(text.to_owned());
    let [ball, bad, cuboid] = &rows[..] else {
        panic!("{rows:?}")
    };
    assert_eq!(
        ball[..4],
        [
            Field::Long(1),
            text("ball.csg"),
            Field::Double(0.5),
            Field::Null
        ]
    );
    assert_eq!(
        bad[..5],
        [
            Field::Long(2),
            text("bad.csg"),
            Field::Null,
            text("late"),
            Field::Null
        ]
    );
    assert!(matches!(&bad[20], Field::Str(why) if why.contains("roof")));
    assert_eq!(cuboid[2..4], [Field::Double(2.0), text("3")]);
    assert!(matches!(cuboid[4], Field::Double(volume) if (volume - 6.0).abs() < 1e-12));
    assert_eq!(cuboid[17], Field::Long(0));
}

#[test]
fn wrong_tables_and_names_are_told() {
    let folder = folder();
    fs::write(folder.file("taken.csv"), "volume\n1\n").expect("a file");
    fs::write(folder.file("twice.csv"), "model\nin.csg\nbox.csg\nin.csg\n").expect("a file");
    fs::write(folder.file("ragged.csv"), "model,a\nin.csg\n").expect("a file");
    fs::write(folder.file("names.csv"), "model,bore,bore\nin.csg,1,2\n").expect("a file");
    let output = failed(&folder.run("sweep table.csv -o nowhere/out.csv"), 5);
    assert!(output.contains("nowhere/out.csv"), "{output}");
    for (arguments, code, words) in [
        ("sweep no.csv -o out.csv", 3, "no.csv"),
        ("sweep taken.csv -o out.csv", 3, "`volume`"),
        ("sweep ragged.csv -o out.csv", 3, "ragged.csv"),
        ("sweep table.csv -o out.csv --write part.stl", 2, "{row}"),
        (
            "sweep table.csv -o out.csv --write {bore}.stl",
            2,
            "model, note",
        ),
        ("sweep table.csv -o out.csv --write {row}.dwg", 2, ".glb"),
        (
            "sweep twice.csv -o out.csv --write {model}.stl",
            2,
            "rows 1 and 3 would have one file",
        ),
        ("sweep table.csv -o out.csv --shard 3/2", 2, "1/4"),
        ("sweep table.csv -o out.xlsx", 2, ".csv"),
        ("sweep table.csv -o out", 2, ".csv"),
        ("sweep in.csg -o out.csv", 3, "--model"),
        ("sweep ball.stl -o out.csv", 3, "not a table"),
        ("sweep table.parquet -o out.csv", 3, "save it as .csv"),
        ("sweep names.csv -o out.csv", 3, "called `bore`"),
    ] {
        let message = failed(&folder.run(arguments), code);
        assert!(message.contains(words), "{arguments}: {message}");
        assert!(!folder.file("out.csv").exists());
    }
}

/// By its own name, by another path, and by a link that leads to it.
#[test]
fn the_table_of_variants_is_not_written_over() {
    let folder = folder();
    #[cfg(unix)]
    std::os::unix::fs::symlink("table.csv", folder.file("link.csv")).expect("a link");
    let elsewhere = folder.file("table.csv").display().to_string();
    let mut outputs = vec!["table.csv", "./table.csv", &elsewhere];
    if cfg!(unix) {
        outputs.push("link.csv");
    }
    for output in outputs {
        let message = failed(&folder.run(&format!("sweep table.csv -o {output}")), 2);
        assert!(message.contains("is the table of variants"), "{message}");
        let kept = fs::read_to_string(folder.file("table.csv")).expect("a table");
        assert_eq!(kept, TABLE);
    }
}

#[test]
fn tables_without_rows_are_told_and_other_separators_read() {
    let folder = folder();
    for (name, text) in [
        ("empty.csv", ""),
        ("comments.csv", "# model\n\n"),
        ("names.csv", "model,note\n"),
        (
            "semicolons.csv",
            "# a, b\nmodel;note\nbox.csg;\"a; b, c\"\n",
        ),
        ("tabulators.csv", "model\tnote\nbox.csg\ta, b\n"),
    ] {
        fs::write(folder.file(name), text).expect("a file");
    }
    for name in ["empty.csv", "comments.csv"] {
        let message = failed(&folder.run(&format!("sweep {name} -o out.csv")), 3);
        assert!(message.contains("it is empty"), "{message}");
        assert!(!folder.file("out.csv").exists());
    }
    let output = folder.run("sweep names.csv -o out.csv");
    let said = String::from_utf8_lossy(&succeeded(&output).stderr).into_owned();
    assert!(
        said.contains("names.csv has no rows below its names"),
        "{said}"
    );
    for (name, note) in [("semicolons", "\"a; b, c\""), ("tabulators", "\"a, b\"")] {
        succeeded(&folder.run(&format!("sweep {name}.csv -o out.csv")));
        let text = fs::read_to_string(folder.file("out.csv")).expect("a table");
        let row = text.lines().nth(1).expect("a row");
        assert!(row.starts_with(&format!("1,box.csg,{note},6")), "{row}");
    }
    let message = failed(
        &folder.run("sweep table.csv -o out.csv --write no/{row}.stl"),
        5,
    );
    assert!(message.contains("no/1.stl") && message.contains("nothing was written"));
}

#[test]
fn completions_and_manual_pages_know_every_command() {
    let folder = Folder::new();
    let commands = [
        "mesh", "render", "measure", "section", "convert", "info", "compare", "sweep",
    ];
    for shell in ["bash", "zsh", "fish"] {
        let output = folder.run(&format!("completions {shell}"));
        let script = String::from_utf8_lossy(&succeeded(&output).stdout).into_owned();
        for command in commands {
            assert!(script.contains(command), "{shell}: {command}");
        }
    }
    fs::create_dir(folder.file("man")).expect("a folder");
    succeeded(&folder.run("man man"));
    for command in commands {
        let page = fs::read_to_string(folder.file(&format!("man/csg-{command}.1")));
        assert!(page.expect("a page").contains(".SH OPTIONS"), "{command}");
    }
}
