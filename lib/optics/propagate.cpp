// Method: Fraunhofer diffraction, wavelength by wavelength. With E the pupil field, F its Fourier transform and w the
// photons of the wavelength,
//     E = A exp(2 pi i (OPD + x u_0 + y v_0)/lambda),   I(u, v) = sum over lambda of w |F|^2 (D/N p/lambda)^2 a/area,
// a the area of a pixel in units of p^2.
// Derivatives are exact: d/du_0 multiplies E by (2 pi i/lambda) x, defocus by (2 pi i/lambda) Z_4, so that each is one
// more propagated field, and Leibniz' rule makes the derivatives of |F|^2 = F conj(F) from their products. Finite
// differences would amplify rounding errors. Images are in double precision: in single precision the difference
// image of a displacement of 1e-6 px is 33 % wrong.
#include "optics/propagate.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "base/constants.hpp"
#include "base/workers.hpp"

namespace toliman::optics {

namespace {

using kernels::FieldProduct;
using kernels::FieldTerm;

using ImageList = std::vector<Buffer<double>>;

struct Order {
    size_t along, across;
};

// The requested orders, each after the orders that it is made from.
std::vector<Order> orders_of(const ImageRequest &request) {
    std::vector<Order> orders;
    for (size_t total = 0; total <= std::max(request.along, request.plane); total++)
        for (size_t across = 0; across <= (total <= request.plane ? total : 0); across++)
            orders.push_back({total - across, across});
    return orders;
}

size_t index_of(const std::vector<Order> &orders, size_t along, size_t across) noexcept {
    size_t i = 0;
    while (orders[i].along != along || orders[i].across != across)
        i++;
    return i;
}

double binomial(size_t n, size_t k) noexcept {
    double value = 1;
    for (size_t i = 0; i < k; i++)
        value = value * static_cast<double>(n - i) / static_cast<double>(i + 1);
    return value;
}

// Leibniz' rule: the derivative of order (a, c) of F conj(F) is the sum over i <= a, j <= c of binomial(a, i)
// binomial(c, j) F_(i, j) conj(F_(a-i, c-j)). Complex conjugate pairs are one product with twice the factor.
std::vector<FieldProduct> products_of(const std::vector<Order> &orders, size_t focus_orders, size_t modes) {
    std::vector<FieldProduct> products;
    for (size_t image = 0; image < orders.size(); image++) {
        const Order whole = orders[image];
        for (size_t a = 0; a <= whole.along; a++) {
            for (size_t b = 0; b <= whole.across; b++) {
                const size_t p = index_of(orders, a, b), q = index_of(orders, whole.along - a, whole.across - b);
                if (p <= q)
                    products.push_back(
                        {image, p, q, binomial(whole.along, a) * binomial(whole.across, b) * (p < q ? 2 : 1)});
            }
        }
    }
    const size_t focus = orders.size(), curve = focus + 1;
    if (focus_orders > 0)
        products.push_back({focus, 0, focus, 2});
    if (focus_orders > 1) {
        products.push_back({curve, 0, curve, 2});
        products.push_back({curve, focus, focus, 2});
    }
    for (size_t mode = focus + focus_orders; mode < focus + focus_orders + modes; mode++)
        products.push_back({mode, 0, mode, 2});
    return products;
}

// What no thread uses at present, of several megabytes each, so that a thread's next chunk takes that of its last one.
// It is released on the thread of the pool, also after a failure: its memory may be the caller's.
template <class T> class Pool {
  public:
    Pool(size_t most, std::function<T()> make) : make_(std::move(make)) { idle_.reserve(most); }
    struct Loan {
        explicit Loan(Pool &pool) : lender(pool), one(pool.take()) {}
        ~Loan() { lender.give_back(std::move(one)); }
        Loan(const Loan &) = delete;
        Loan &operator=(const Loan &) = delete;
        Pool &lender;
        T one;
    };

  private:
    T take() {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            if (!idle_.empty()) {
                T one = std::move(idle_.back());
                idle_.pop_back();
                return one;
            }
        }
        return make_();
    }
    void give_back(T one) noexcept {
        const std::lock_guard<std::mutex> lock(mutex_);
        idle_.push_back(std::move(one));
    }

  private:
    const std::function<T()> make_;
    std::mutex mutex_;
    std::vector<T> idle_;
};

// Shared by all threads.
struct Task {
    const Light &light;
    const Grid &grid;
    const std::vector<std::vector<double>> &spectra; // photons [spectrum][wavelength]
    long double offset[2]; // px; in double a displacement of 1e-10 px added to 40 px would be off by 7e-15 px
    std::vector<Order> orders;
    std::vector<FieldProduct> products;
    size_t focus_orders;                    // derivatives by defocus, after those by position
    const std::vector<const Mode *> &modes; // after those by defocus

    size_t images() const noexcept { return orders.size() + focus_orders + modes.size(); } // of each spectrum
};

// One chunk of the wavelengths, on one thread: work space for the fields of one wavelength, and the chunk's images.
class Chunk {
  public:
    // images: zeros, of one spectrum after the other; they outlive the chunk.
    Chunk(const Task &task, Transform &transform, ImageList &images);
    void add(size_t wavelength);

  private:
    void set_terms(const Pupil &pupil, long double wavenumber);

    const Task &task_;
    std::vector<FieldTerm> terms_;
    std::vector<FieldProduct> weighted_; // task_.products of every spectrum times its weight of the wavelength
    Transform &transform_;
    std::vector<double *> image_of_;
    std::vector<Buffer<double>> amplitude_, opd_m_; // of the modes of cells
};

Chunk::Chunk(const Task &task, Transform &transform, ImageList &images) : task_(task), transform_(transform) {
    for (size_t spectrum = 0; spectrum < task.spectra.size(); spectrum++)
        for (FieldProduct product : task.products) {
            product.image += spectrum * task.images();
            weighted_.push_back(product);
        }
    for (Buffer<double> &image : images)
        image_of_.push_back(image.data());
    amplitude_.resize(task.modes.size());
    opd_m_.resize(task.modes.size());
}

void Chunk::set_terms(const Pupil &pupil, long double wavenumber) {
    const double *const axis = task_.light.axis;
    terms_.clear();
    for (size_t i = 1; i < task_.orders.size(); i++) {
        const Order order = task_.orders[i];
        if (order.along > 0)
            terms_.push_back(position_term(index_of(task_.orders, order.along - 1, order.across), pupil, task_.grid,
                                           wavenumber, axis[0], axis[1]));
        else
            terms_.push_back(position_term(index_of(task_.orders, order.along, order.across - 1), pupil, task_.grid,
                                           wavenumber, -axis[1], axis[0]));
    }
    for (size_t i = 0; i < task_.focus_orders; i++)
        terms_.push_back(focus_term(i == 0 ? 0 : task_.orders.size(), pupil, wavenumber));
    for (size_t i = 0; i < task_.modes.size(); i++) {
        const Mode &mode = *task_.modes[i];
        FieldTerm term = {0, 0, 0, mode.opd_m.data(), static_cast<double>(2 * kLongPi * wavenumber)};
        if (mode.opd_m.empty()) {
            for (Buffer<double> *map : {&amplitude_[i], &opd_m_[i]})
                map->resize(pupil.samples * pupil.samples);
            field_of(pupil, mode, static_cast<double>(wavenumber), amplitude_[i].data(), opd_m_[i].data());
            term.amplitude = amplitude_[i].data();
            term.opd_m = opd_m_[i].data();
        }
        terms_.push_back(term);
    }
}

void Chunk::add(size_t wavelength) {
    const auto &spectra = task_.spectra;
    if (std::all_of(spectra.begin(), spectra.end(), [=](const auto &photons) { return photons[wavelength] == 0; }))
        return;
    const long double wavenumber = 1 / static_cast<long double>(task_.light.wavelength_m[wavelength]);
    const Pupil &pupil = transform_.pupil(wavenumber);
    set_terms(pupil, wavenumber);
    const auto moved = task_.light.dispersed_px(task_.light.wavelength_m[wavelength]);
    const long double offset[2] = {task_.offset[0] + moved[0], task_.offset[1] + moved[1]};
    transform_.transform(wavenumber, offset, terms_);
    const size_t count = task_.products.size();
    for (size_t s = 0; s < spectra.size(); s++) {
        const double weight = intensity_factor(pupil, task_.grid, wavenumber, spectra[s][wavelength]);
        for (size_t i = 0; i < count; i++)
            weighted_[s * count + i].factor = weight * task_.products[i].factor;
    }
    transform_.accumulate(weighted_, image_of_.data());
}

// Derivative of an image whose points u move to u + s M u and whose light spreads over (1 + s tr M) times the area, by
// s at s = 0: -(M u) . grad I - tr(M) I. The gradient of an image is minus its derivative by the star's position.
Buffer<double> stretched(const StarImages &images, const Light &light, const Grid &grid, const double (&m)[2][2]) {
    const Buffer<double> &image = images.at(0, 0), &along = images.at(1, 0), &across = images.at(0, 1);
    const double centre_x = 0.5 * static_cast<double>(grid.cols - 1),
                 centre_y = 0.5 * static_cast<double>(grid.rows - 1);
    Buffer<double> result(image.size());
    for (size_t i = 0; i < result.size(); i++) {
        const size_t row = i / grid.cols, col = i % grid.cols;
        const double x = static_cast<double>(col) - centre_x, y = static_cast<double>(row) - centre_y;
        const double u = m[0][0] * x + m[0][1] * y, v = m[1][0] * x + m[1][1] * y;
        result[i] = (u * light.axis[0] + v * light.axis[1]) * along[i] +
                    (v * light.axis[0] - u * light.axis[1]) * across[i] - (m[0][0] + m[1][1]) * image[i];
    }
    return result;
}

// The sum of the chunks in their order. A chunk waits for those before it, so that a few are held at once, rarely all.
class ChunkSums {
  public:
    using Loan = std::unique_ptr<Pool<ImageList>::Loan>;
    ChunkSums(size_t chunks, ImageList zeros) : waiting_(chunks), sums_(std::move(zeros)) {}
    void add(size_t chunk, Loan images) {
        std::unique_lock<std::mutex> lock(mutex_);
        waiting_[chunk] = std::move(images);
        while (!adding_ && next_ < waiting_.size() && waiting_[next_] != nullptr) {
            const Loan part = std::move(waiting_[next_++]);
            adding_ = true; // others continue with their next chunk
            lock.unlock();
            for (size_t image = 0; image < sums_.size(); image++)
                for (size_t i = 0; i < sums_[image].size(); i++)
                    sums_[image][i] += std::exchange(part->one[image][i], 0);
            lock.lock();
            adding_ = false;
        }
    }
    ImageList release() noexcept { return std::move(sums_); }

  private:
    std::mutex mutex_;
    bool adding_ = false;
    std::vector<Loan> waiting_;
    size_t next_ = 0;
    ImageList sums_;
};

// Sums of the chunks, of one spectrum after the other.
ImageList sums_of(const Engine &engine, const Task &task, unsigned workers,
                  const std::function<void(double)> &on_progress) {
    const size_t count = task.light.wavelength_m.size(), chunks = std::min(count, kWavelengthChunks);
    const auto zeros = [&] {
        return ImageList(task.spectra.size() * task.images(), Buffer<double>(task.grid.rows * task.grid.cols));
    };
    Pool<std::unique_ptr<Transform>> transforms(chunks, [&] { return engine(task.grid, task.images()); });
    Pool<ImageList> images(chunks, zeros);
    ChunkSums sums(chunks, zeros());
    run_jobs(
        workers, chunks,
        [&](size_t part) {
            auto own = std::make_unique<Pool<ImageList>::Loan>(images);
            const Pool<std::unique_ptr<Transform>>::Loan transform(transforms);
            Chunk chunk(task, *transform.one, own->one);
            for (size_t i = part; i < count; i += chunks)
                chunk.add(i);
            sums.add(part, std::move(own));
        },
        on_progress);
    return sums.release();
}

// The images of a spectrum from the sums, which are taken.
StarImages images_of(const Task &task, const ImageRequest &request, Buffer<double> *sums) {
    const Light &light = task.light;
    const Grid &grid = task.grid;
    StarImages result;
    for (size_t i = 0; i < task.orders.size(); i++)
        result.derivatives.push_back({task.orders[i].along, task.orders[i].across, std::move(sums[i])});
    if (request.focus) {
        result.focus = std::move(sums[task.orders.size()]);
        result.scale = stretched(result, light, grid, {{1, 0}, {0, 1}});
    }
    if (task.focus_orders > 1)
        result.focus_curve = std::move(sums[task.orders.size() + 1]);
    if (request.geometry) {
        // pixels = G angle, M = dG G^-1 with G^-1 = (u_x 0; v_x v_y) and dG = (1 0; 0 -1) or (0 0; 1 0).
        const auto u_x = static_cast<double>(grid.u_x), v_x = static_cast<double>(grid.v_x),
                   v_y = static_cast<double>(grid.v_y);
        result.anisotropy = stretched(result, light, grid, {{u_x, 0}, {-v_x, -v_y}});
        result.shear = stretched(result, light, grid, {{0, 0}, {u_x, 0}});
    }
    for (size_t i = 0; i < task.modes.size(); i++)
        result.modes.push_back(std::move(sums[task.orders.size() + task.focus_orders + i]));
    return result;
}

std::vector<StarImages> propagate_at(const Engine &engine, const Light &light, const Grid &grid,
                                     const std::vector<std::vector<double>> &spectra, const long double *offset,
                                     const ImageRequest &request, unsigned workers,
                                     const std::function<void(double)> &on_progress) {
    Task task = {light, grid, spectra, {offset[0], offset[1]}, orders_of(request), {}, 0, request.modes};
    if (request.focus)
        task.focus_orders = request.focus_curve ? 2 : 1;
    task.products = products_of(task.orders, task.focus_orders, task.modes.size());
    ImageList sums = sums_of(engine, task, workers, on_progress);
    std::vector<StarImages> images;
    for (size_t spectrum = 0; spectrum < spectra.size(); spectrum++)
        images.push_back(images_of(task, request, sums.data() + spectrum * task.images()));
    return images;
}

} // namespace

const Buffer<double> &StarImages::at(size_t along, size_t across) const noexcept {
    size_t i = 0;
    while (derivatives[i].along != along || derivatives[i].across != across)
        i++;
    return derivatives[i].image;
}

StarImages propagate(const Engine &engine, const Light &light, const Grid &grid, size_t star, double displacement_px,
                     const ImageRequest &request, unsigned workers, const std::function<void(double)> &on_progress) {
    long double offset[2];
    for (size_t axis = 0; axis < 2; axis++)
        offset[axis] = light.offset_px[star][axis] + static_cast<long double>(displacement_px) * light.axis[axis];
    std::vector<StarImages> images =
        propagate_at(engine, light, grid, {light.photons[star]}, offset, request, workers, on_progress);
    return std::move(images[0]);
}

std::vector<StarImages> propagate(const Engine &engine, const Light &light, const Grid &grid,
                                  const std::vector<std::vector<double>> &spectra, const ImageRequest &request,
                                  unsigned workers, const std::function<void(double)> &on_progress) {
    const long double offset[2] = {light.offset_px[0][0], light.offset_px[0][1]};
    return propagate_at(engine, light, grid, spectra, offset, request, workers, on_progress);
}

} // namespace toliman::optics
