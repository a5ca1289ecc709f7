#include "optics/efficiency.hpp"

#include "base/error.hpp"

namespace toliman::optics {

Efficiency::Efficiency(const Scene &scene) : scene_(scene) {
    for (const Throughput &factor : scene.telescope.throughput) {
        tables_.emplace_back();
        if (!factor.file.empty())
            tables_.back().emplace(factor.file, Curve::throughput);
    }
    if (!scene.detector.qe_file.empty())
        qe_.emplace(scene.detector.qe_file, Curve::qe);
}

double Efficiency::value(const SpectrumTable &table, const std::string &key, double wavelength_nm) const {
    if (!table.covers(wavelength_nm, wavelength_nm))
        fail(Status::scene,
             "%s: {%s}: the file covers %g to %g nm: must cover the light of the scene, of which there is %g nm",
             scene_.source.c_str(), key.c_str(), table.first_nm(), table.last_nm(), wavelength_nm);
    return table.at(wavelength_nm);
}

double Efficiency::throughput(double wavelength_nm) const {
    double product = 1;
    for (size_t i = 0; i < tables_.size(); i++)
        product *= tables_[i] ? value(*tables_[i], "telescope.throughput[" + std::to_string(i) + "]", wavelength_nm)
                              : scene_.telescope.throughput[i].factor;
    return product;
}

double Efficiency::qe(double wavelength_nm) const {
    if (!qe_)
        return 1;
    const double qe = value(*qe_, "detector.qe", wavelength_nm);
    if (!(qe > 0))
        fail(Status::scene, "%s: {detector.qe}: the file has 0 at %g nm: must be above 0 in the light of the scene",
             scene_.source.c_str(), wavelength_nm);
    return qe;
}

} // namespace toliman::optics
