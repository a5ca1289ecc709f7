// Writes frames as the mission's older image service: frame_proc_CAMTIME.fits.gz with an empty primary unit that has
// the keywords, and the tile-compressed image CORE. CFITSIO makes the file in memory, zlib compresses it.
#include <cstdlib>
#include <new>
#include <zlib.h>

#include "frames/fits.hpp"
#include "frames/frames_out.hpp"
#include "frames/stream_output.hpp"

namespace cli {

namespace {

constexpr int kGzip = 15 + 16, kLevel = 1, kMemory = 8; // of deflateInit2
constexpr int kMiddle = 64; // CENTR_X and CENTR_Y of a core whose first pixel is the first one of the detector

// Memory of a file that CFITSIO makes.
struct FileMemory {
    FileMemory() = default;
    FileMemory(const FileMemory &) = delete;
    FileMemory &operator=(const FileMemory &) = delete;
    ~FileMemory() { std::free(data); }
    void *data = nullptr;
    size_t size = 0;
};

std::vector<uint8_t> compressed(const FileMemory &file) {
    z_stream zip = {};
    if (deflateInit2(&zip, kLevel, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
        throw std::bad_alloc();
    std::vector<uint8_t> bytes(deflateBound(&zip, static_cast<uLong>(file.size)));
    zip.next_in = static_cast<Bytef *>(file.data);
    zip.avail_in = static_cast<uInt>(file.size);
    zip.next_out = bytes.data();
    zip.avail_out = static_cast<uInt>(bytes.size());
    deflate(&zip, Z_FINISH);
    bytes.resize(zip.total_out);
    deflateEnd(&zip);
    return bytes;
}

class FitsStream : public StreamOutput {
  public:
    using StreamOutput::StreamOutput;

    void add(const Exposure &exposure, const uint16_t *counts) override {
        const std::string path = layout_.folder.file("frame_proc_" + std::to_string(exposure.stamp_ns) + ".fits.gz");
        FileMemory memory;
        if (const int status = make(exposure, counts, memory))
            throw Failure(kExitOutput, path + ": cannot be written: " + fits_reason(status));
        OutputFile file(free_path(path));
        file.write(compressed(memory));
        file.commit();
        layout_.folder.keep();
    }

  private:
    int make(const Exposure &exposure, const uint16_t *counts, FileMemory &memory) const {
        constexpr size_t kBlock = 2880;
        memory.size = kBlock;
        memory.data = std::calloc(1, memory.size);
        if (memory.data == nullptr)
            throw std::bad_alloc();
        fitsfile *made = nullptr;
        int status = 0, middle = kMiddle, zero = 0;
        cfitsio().create_memfile(&made, &memory.data, &memory.size, 0, std::realloc, &status);
        const Fits file(made);
        long axes[] = {static_cast<long>(layout_.cols), static_cast<long>(layout_.rows)};
        long long number = exposure.frame_id;
        double us = layout_.exposure_s * 1e6;
        char core[] = "CORE";
        std::string time = std::to_string(exposure.stamp_ns);
        cfitsio().create_img(made, BYTE_IMG, 0, nullptr, &status);
        cfitsio().write_key(made, TLONGLONG, "SEQNUM", &number, "number of the frame", &status);
        cfitsio().write_key(made, TSTRING, "CAMTIME", time.data(), "[ns] start of the exposure, camera's clock",
                            &status);
        cfitsio().write_key(made, TDOUBLE, "EXPOSURE", &us, "[us] length of the exposure", &status);
        for (const char *key : {"XOFF", "YOFF"})
            cfitsio().write_key(made, TINT, key, &zero, "[pixel] first one of the region", &status);
        for (const char *key : {"CENTR_X", "CENTR_Y"})
            cfitsio().write_key(made, TINT, key, &middle, "[pixel] middle of the core", &status);
        cfitsio().set_compression_type(made, RICE_1, &status);
        cfitsio().create_img(made, USHORT_IMG, 2, axes, &status);
        cfitsio().write_key(made, TSTRING, "EXTNAME", core, "", &status);
        cfitsio().write_img(made, TUSHORT, 1, static_cast<LONGLONG>(layout_.pixels()), const_cast<uint16_t *>(counts),
                            &status);
        cfitsio().flush_file(made, &status);
        if (status == 0)
            memory.size = static_cast<size_t>(made->Fptr->filesize);
        return status;
    }
};

} // namespace

std::unique_ptr<StreamOutput> fits_stream(const StreamLayout &layout) {
    return std::make_unique<FitsStream>(layout);
}

} // namespace cli
