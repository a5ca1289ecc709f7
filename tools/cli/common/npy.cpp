#include "common/npy.hpp"

#include "common/content.hpp"

namespace cli {

namespace {

void write_header(OutputFile &out, const char *type, const std::vector<size_t> &shape) {
    std::string text = std::string(kNpyMark) + type + "', 'fortran_order': False, 'shape': (";
    for (size_t i = 0; i < shape.size(); i++)
        text += (i > 0 ? ", " : "") + std::to_string(shape[i]);
    text += shape.size() == 1 ? ",), }" : "), }";
    text.resize(kNpyHeaderSize - 1, ' ');
    out.write(text + "\n");
}

} // namespace

void write_npy_header(OutputFile &out, const std::vector<size_t> &shape) {
    write_header(out, "<f8", shape);
}

void write_npy(OutputFile &out, const std::vector<double> &values, const std::vector<size_t> &shape) {
    write_npy_header(out, shape.empty() ? std::vector{values.size()} : shape);
    out.write(values);
}

void write_npy(OutputFile &out, const std::vector<uint8_t> &values, const std::vector<size_t> &shape) {
    write_header(out, "|u1", shape);
    out.write(values);
}

toliman::NpyHeader read_npy_header(InputFile &file) {
    if (file.ended())
        malformed(file.path(), "is empty");
    toliman::NpyHeader header;
    const auto read = [&](void *data, size_t size) { return file.read(data, size); };
    const std::string complaint = toliman::read_npy_header(read, header);
    if (!complaint.empty())
        malformed(file.path(), complaint + (complaint == "is not a .npy file" ? kind_of(file.path()) : ""));
    return header;
}

} // namespace cli
