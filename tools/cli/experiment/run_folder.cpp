#include "experiment/run_folder.hpp"

#include <functional>

#include "common/content.hpp"
#include "common/npy.hpp"
#include "common/text.hpp"

namespace cli {

RunFolder::RunFolder(const std::string &path) : folder_(path), images_(folder_.file("images")) {
    for (const char *name : {"result.json", "series.csv", "periodogram.csv", "training.csv", "displacement.csv"})
        folder_.open(name);
    folder_.open("scene.json", Replaces::scenes);
    folder_.open("weights.tlmw");
    for (const char *name : kRunImages)
        images_.open(name);
}

void RunFolder::write(const RunFiles &files) {
    const Pipeline &pipeline = files.pipeline;
    const Cadence &cadence = files.cadence;
    const auto csv = [&](const char *name, const char *mark, const char *header, size_t rows,
                         const std::function<std::string(size_t)> &row) {
        OutputFile &out = folder_.open(name);
        out.write(std::string(mark) + header);
        for (size_t k = 0; k < rows; k++)
            out.write(row(k));
    };
    csv("series.csv", kSeriesMark, "frame,t,true,latent,template\n", cadence.times.size(), [&](size_t k) {
        return formatted("%zu,%.17g,%.17g,%.17g,%.17g\n", k, cadence.times[k], cadence.displacements[k],
                         pipeline.latents[k], pipeline.estimates[k]);
    });
    csv("periodogram.csv", kPeriodogramMark, "frequency,power,template,true\n", pipeline.latent.power.size(),
        [&](size_t k) {
            return formatted("%.17g,%.17g,%.17g,%.17g\n", pipeline.grid.f0 + pipeline.grid.df * static_cast<double>(k),
                             pipeline.latent.power[k], pipeline.estimate.power[k], pipeline.truth.power[k]);
        });
    csv("training.csv", kTrainingMark, "step,loss\n", pipeline.losses.size(),
        [&](size_t k) { return formatted("%zu,%.17g\n", k + 1, pipeline.losses[k]); });
    csv("displacement.csv", kDisplacementMark, "displacement_px,linear,cubic,linear_change,cubic_change,taylor\n",
        files.displacements.size(), [&](size_t k) {
            const DisplacementErrors &one = files.displacements[k];
            return formatted("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", one.displacement_px, one.linear, one.cubic,
                             one.linear_change, one.cubic_change, one.taylor);
        });
    folder_.open("scene.json").write(files.scene);
    folder_.open("weights.tlmw").write(pipeline.weights);
    folder_.open("result.json").write(files.result);
    for (size_t i = 0; i < files.images.size(); i++)
        write_npy(images_.open(kRunImages[i]), files.images[i].values, files.images[i].shape);
    images_.commit();
    folder_.commit("result.json");
}

} // namespace cli
