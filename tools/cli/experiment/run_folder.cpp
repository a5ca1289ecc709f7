#include "experiment/run_folder.hpp"

#include "common/content.hpp"
#include "common/npy.hpp"

namespace cli {

namespace {

void write_series(OutputFile &out, const Cadence &cadence, const Pipeline &pipeline) {
    out.print("%sframe,t,true,latent,template\n", kSeriesMark);
    for (size_t k = 0; k < cadence.times.size(); k++)
        out.print("%zu,%.17g,%.17g,%.17g,%.17g\n", k, cadence.times[k], cadence.displacements[k], pipeline.latents[k],
                  pipeline.estimates[k]);
}

void write_periodogram(OutputFile &out, const Pipeline &pipeline) {
    out.print("%sfrequency,power,template,true\n", kPeriodogramMark);
    for (size_t k = 0; k < pipeline.power.size(); k++)
        out.print("%.17g,%.17g,%.17g,%.17g\n", pipeline.grid.f0 + pipeline.grid.df * static_cast<double>(k),
                  pipeline.power[k], pipeline.estimate_power[k], pipeline.true_power[k]);
}

void write_training(OutputFile &out, const Pipeline &pipeline) {
    out.print("%sstep,loss\n", kTrainingMark);
    for (size_t k = 0; k < pipeline.losses.size(); k++)
        out.print("%zu,%.17g\n", k + 1, pipeline.losses[k]);
}

void write_displacement(OutputFile &out, const std::vector<DisplacementErrors> &all) {
    out.print("%sdisplacement_px,linear,cubic,linear_change,cubic_change,taylor\n", kDisplacementMark);
    for (const DisplacementErrors &one : all)
        out.print("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", one.displacement_px, one.linear, one.cubic,
                  one.linear_change, one.cubic_change, one.taylor);
}

} // namespace

RunFolder::RunFolder(const std::string &path)
    : folder_(path), image_folder_(folder_.file("images")), result_(add("result.json")), series_(add("series.csv")),
      periodogram_(add("periodogram.csv")), training_(add("training.csv")), displacement_(add("displacement.csv")),
      scene_(add("scene.json", Replaces::scenes)), weights_(add("weights.tlmw")) {
    for (const char *name : kRunImages)
        images_.push_back(&add(std::string("images/") + name + ".npy"));
}

OutputFile &RunFolder::add(const std::string &name, Replaces what) {
    files_.push_back(std::make_unique<OutputFile>(folder_.file(name), what));
    return *files_.back();
}

void RunFolder::write(const RunFiles &files) {
    scene_.write(files.scene.data(), files.scene.size());
    weights_.write(files.pipeline.weights.data(), files.pipeline.weights.size());
    result_.write(files.result.data(), files.result.size());
    write_series(series_, files.cadence, files.pipeline);
    write_periodogram(periodogram_, files.pipeline);
    write_training(training_, files.pipeline);
    write_displacement(displacement_, files.displacements);
    for (size_t i = 0; i < images_.size(); i++) {
        const RunImage &image = files.images[i];
        write_npy_header(*images_[i], image.shape);
        images_[i]->write(image.values.data(), image.values.size() * sizeof image.values[0]);
    }
    for (auto file = files_.rbegin(); file != files_.rend(); ++file)
        (*file)->commit(); // result.json last: it implies that all other files are complete
    image_folder_.keep();
    folder_.keep();
}

} // namespace cli
