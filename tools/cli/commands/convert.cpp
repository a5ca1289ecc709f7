// toliman convert: FITS to .npy and back.
#include "common/content.hpp"
#include "frames/frames_in.hpp"
#include "frames/frames_out.hpp"
#include "options/command.hpp"

namespace cli {

namespace {

struct ConvertOptions {
    std::string in, out;
};

void convert(const ConvertOptions &options, Progress &progress) {
    if (!ends_with(options.in, ".npy") && !is_fits(options.in))
        throw Failure(kExitUsage, "IN " + options.in + ": must end in .npy, .fits or .fits.fz" + kind_of(options.in));
    if (options.out != "-" && !ends_with(options.out, ".npy") && !ends_with(options.out, ".fits"))
        throw Failure(kExitUsage, "OUT " + options.out + ": must end in .npy or .fits, or be - for .npy on stdout");
    check_not_input(options.out, {options.in});
    const auto in = open_frames(options.in);
    const auto out = image_output(options.out, in->axes());
    std::vector<double> image(in->rows() * in->cols());
    for (size_t k = 0; k < in->count(); k++) {
        in->read_finite(image.data());
        out->write(image.data(), 1);
        progress.show("convert", static_cast<double>(k + 1) / static_cast<double>(in->count()));
        stop_if_asked();
    }
    out->commit();
}

} // namespace

void add_convert(CLI::App &app, Context &context) {
    CLI::App *command = add_command(app, "convert");
    auto options = std::make_shared<ConvertOptions>();
    add_option(command, "IN", options->in, "")->required();
    add_option(command, "OUT", options->out, "")->required();
    set_action(*command, context, options, convert);
}

} // namespace cli
