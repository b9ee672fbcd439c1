//! A farm inside a program: two workers render a scene, and the picture is written as `local_farm.png` into the folder for temporary files.
//!
//! ```text
//! cargo run --release --example local_farm -- scenes/cornell-diffuse/scene.xml 16
//! ```

use std::error::Error;

use photonfarm::estimate::picture_files::{encode_png, write_file};
use photonfarm::farm::LocalFarm;
use photonfarm::farm::job::{JobRequest, StopRule};

#[tokio::main]
async fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let scene = arguments.next().unwrap_or_else(|| "scenes/cornell-diffuse/scene.xml".to_owned());
    let passes = arguments.next().map_or(Ok(4), |passes| passes.parse())?;

    let farm = LocalFarm::builder().workers(2).start().await?;
    let scene = farm.client().add_scene(std::fs::read(scene)?).await?;
    let stop = StopRule { passes: Some(passes), ..StopRule::default() };
    let job = farm.client().submit(JobRequest { stop, ..JobRequest::of_scene(scene.hash) }).await?;

    let mut status = farm.client().watch(job)?;
    let ended = status.wait_for(|status| status.state.is_final()).await?.clone();
    println!("job {job} is {} after {} passes, {:.1} s", ended.state.name(), ended.passes_done, ended.seconds);

    let (picture, _) = farm.client().picture(job).await?;
    let file = std::env::temp_dir().join("local_farm.png");
    write_file(&file, &encode_png(&picture, 0.0)?)?;
    println!("{} × {} pixels in {}", picture.width, picture.height, file.display());
    farm.stop().await;
    Ok(())
}
