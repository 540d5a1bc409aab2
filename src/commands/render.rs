//! `render`: a picture of a scene, or many side by side.

use super::painter::PainterArgs;
use super::{Failure, output, print_result, progress, say, scenes};
use rest3d_gpu::files::write_whole;
use rest3d_gpu::render::{
    Cell, Models, Painter, Picture, Sheet, Size, Stage, Viewpoint, camera, share_a_view, sheet, sheet_size, stage,
};
use rest3d_gpu::scene::Scene;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};
use std::slice;
use std::time::Instant;

/// Size of a single picture, and of each picture of several.
const SINGLE: Size = Size { width: 1600, height: 1200 };
const SMALL: Size = Size { width: 800, height: 600 };
/// What a row of a sheet is made of, as file names in the scene's folder; the result is elsewhere.
const INPUT: &str = "scene.json";
/// Place of the result in a row.
const RESULT: usize = 1;
const REFERENCES: [(&str, &str); 2] = [("truth.json", "truth"), ("rest3d.json", "REST3D")];

/// Draw a scene, or several side by side from the same camera, as a PNG
///
/// One SCENE is one picture, several are a row. With --sheet, each SCENE is a folder that gives a row of its own: its
/// scene.json, the result of optimize, and what it is compared with (truth.json or rest3d.json).
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene.json, a folder that holds one, or a REST3D stage2 folder
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// File for the picture
    #[arg(short, long = "output", value_name = "FILE")]
    output: PathBuf,
    /// Where to look from: auto, top, front, back, left, right; degrees around and above, such as 30,25; or x,y,z of
    /// the eye and of what is in the middle, in the scene's frame and unit
    #[arg(long, value_name = "VIEW", default_value = "auto", allow_hyphen_values = true)]
    camera: Viewpoint,
    /// Width x height of each picture [default: 1600x1200, of several 800x600]
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// A row for every folder: input, result, truth or REST3D's own result
    #[arg(long)]
    sheet: bool,
    /// With --sheet: the folder in which optimize left its results, by scene
    #[arg(long, value_name = "DIR", default_value = "out", requires = "sheet")]
    results: PathBuf,
    #[command(flatten)]
    painter: PainterArgs,
    /// Put a summary on stdout as one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs it.
pub fn run(args: &Args) -> Result<(), Failure> {
    let clock = Instant::now();
    let places = slice::from_ref(&args.output);
    output::check_places(places, output::parent(&args.output))?;
    if args.output.extension().is_some_and(|ending| !ending.eq_ignore_ascii_case("png")) {
        let file = args.output.display();
        return Err(Failure::Input(format!("{file}: pictures are written as PNG; end the name given to -o in .png")));
    }
    let single = args.scenes.len() == 1 && !args.sheet;
    let size = args.size.unwrap_or(if single { SINGLE } else { SMALL });
    let rows = if args.sheet {
        args.scenes.iter().map(|folder| Row::of_folder(folder, &args.results)).collect::<Result<Vec<_>, _>>()?
    } else {
        vec![Row::of_scenes(&args.scenes)?]
    };
    let rows = if args.sheet { without_empty_results(rows, &args.results) } else { rows };
    for scene in rows.iter().flat_map(|row| &row.entries).filter_map(|(_, scene)| scene.as_ref()) {
        output::refuse_to_overwrite(scene, places)?;
    }
    output::check_writable(output::parent(&args.output))?;
    if !single {
        let columns = rows.iter().map(|row| row.entries.len()).max().unwrap_or(0);
        sheet_size(rows.len(), columns, size)?;
    }
    let painter = args.painter.open()?;
    let (mut models, mut count) = (Models::default(), 0);
    let bar = progress::bar(rows.len() as u64, progress::SHORT);
    let mut drawn = Vec::new();
    for row in &rows {
        bar.set_message(row.name.clone());
        let cells = row.draw(&mut models, painter.as_ref(), args.camera, size)?;
        count += cells.iter().flatten().count();
        drawn.push(cells);
        bar.inc(1);
        // The next folder has other meshes.
        models = Models::default();
    }
    bar.finish_and_clear();
    let picture = match (single, drawn.first_mut().and_then(|cells| cells.first_mut()).and_then(Option::take)) {
        (true, Some(picture)) => picture,
        (_, first) => {
            if let (Some(place), Some(first)) = (drawn.first_mut().and_then(|cells| cells.first_mut()), first) {
                *place = Some(first);
            }
            let rows = rows.into_iter().zip(drawn).map(|(row, pictures)| row.cells(pictures)).collect();
            sheet(&Sheet { rows, cell: size })?
        }
    };
    let bytes = picture.png()?;
    write_whole(&args.output, &bytes).map_err(|error| Failure::writing(&args.output, error))?;
    let summary = Summary {
        file: args.output.display().to_string(),
        width: picture.size.width,
        height: picture.size.height,
        pictures: count,
        painter: painter.describe(),
        seconds: clock.elapsed().as_secs_f64(),
    };
    print_result(args.json, &summary, &summary)
}

/// Leaves the column of results out if there is none at all.
fn without_empty_results(mut rows: Vec<Row>, results: &Path) -> Vec<Row> {
    if rows.iter().all(|row| row.entries[RESULT].1.is_none()) {
        say(format_args!("{}: no result of any of these scenes; --results names another folder", results.display()));
        rows.iter_mut().for_each(|row| drop(row.entries.remove(RESULT)));
    }
    rows
}

/// Scenes that are compared with each other.
struct Row {
    name: String,
    /// What stands under each picture; a scene that is not there leaves its place empty.
    entries: Vec<(String, Option<Scene>)>,
}

impl Row {
    /// The scenes as they were named.
    fn of_scenes(paths: &[PathBuf]) -> Result<Self, Failure> {
        let scenes: Vec<Scene> = paths.iter().map(|path| scenes::read(path)).collect::<Result<_, _>>()?;
        let name = scenes.first().map_or_else(String::new, |scene| scene.name.clone());
        let entries = paths.iter().zip(scenes).map(|(path, scene)| (path.display().to_string(), Some(scene))).collect();
        Ok(Self { name, entries })
    }

    /// Input, result and reference of a folder.
    fn of_folder(folder: &Path, results: &Path) -> Result<Self, Failure> {
        let input = scenes::read(&folder.join(INPUT))?;
        let name = input.name.clone();
        let result = results.join(output::folder_name(&name)).join(INPUT);
        let result = if result.exists() {
            ("result".to_owned(), Some(scenes::read(&result)?))
        } else {
            (format!("no result in {}", output::parent(&result).display()), None)
        };
        let mut entries = vec![("input".to_owned(), Some(input)), result];
        for (file, label) in REFERENCES {
            let file = folder.join(file);
            if file.exists() {
                entries.push((label.to_owned(), Some(scenes::read(&file)?)));
            }
        }
        Ok(Self { name, entries })
    }

    /// The pictures, all from one camera unless the scenes lie too far apart for that.
    fn draw(
        &self,
        models: &mut Models,
        painter: &dyn Painter,
        viewpoint: Viewpoint,
        size: Size,
    ) -> Result<Vec<Option<Picture>>, Failure> {
        let mut stages: Vec<Option<(&Scene, Stage)>> = Vec::new();
        for (_, scene) in &self.entries {
            let staged = scene.as_ref().map(|scene| Ok::<_, Failure>((scene, stage(scene, models)?))).transpose()?;
            for note in staged.iter().flat_map(|(_, stage)| &stage.notes) {
                say(format_args!("warning: {note}"));
            }
            stages.push(staged);
        }
        let all: Vec<&Stage> = stages.iter().flatten().map(|(_, stage)| stage).collect();
        let Some(&(scene, _)) = stages.iter().flatten().next() else { return Ok(Vec::new()) };
        let shared = share_a_view(&all).then(|| camera(viewpoint, scene, &all, size));
        if shared.is_none() {
            say(format_args!("warning: {}: the scenes lie too far apart for one camera; each has its own", self.name));
        }
        let paint = |staged: &Option<(&Scene, Stage)>| {
            let Some((scene, stage)) = staged else { return Ok(None) };
            let camera = shared.unwrap_or_else(|| camera(viewpoint, scene, &[stage], size));
            Ok(Some(painter.paint(stage, &camera, size)?))
        };
        stages.iter().map(paint).collect()
    }

    fn cells(self, pictures: Vec<Option<Picture>>) -> (String, Vec<Cell>) {
        let cells = self.entries.into_iter().zip(pictures);
        (self.name, cells.map(|((label, _), picture)| Cell { label, picture }).collect())
    }
}

/// What is said when the picture is there.
#[derive(Debug, Serialize)]
struct Summary {
    file: String,
    width: u32,
    height: u32,
    pictures: usize,
    painter: String,
    seconds: f64,
}

impl Display for Summary {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { file, width, height, painter, seconds, .. } = self;
        write!(f, "{file}: {width}x{height}, drawn by {painter} in {seconds:.2} s")
    }
}
