// The encoder of layout `paper` in oneDNN, one thread: milliseconds per image, as one JSON object.
#include <cstdio>
#include <unordered_map>
#include <vector>

#include <oneapi/dnnl/dnnl.hpp>

#include "timing.hpp"

using namespace dnnl;

namespace {

struct Call {
    primitive what;
    std::unordered_map<int, memory> with;
};

memory::desc image(memory::dim channels, memory::dim side, memory::format_tag tag) {
    return {{1, channels, side, side}, memory::data_type::f32, tag};
}

} // namespace

int main() {
    engine cpu(engine::kind::cpu, 0);
    stream order(cpu);
    std::vector<Call> calls;
    const memory::dim channels[] = {1, 8, 16, 32, 64};
    using Tag = memory::format_tag;
    memory now(image(1, 256, Tag::nchw), cpu);
    for (int k = 0; k < 4; k++) {
        const memory::dim side = 256 >> k, to = channels[k + 1];
        post_ops elu;
        elu.append_eltwise(1.0f, algorithm::eltwise_elu, 1.0f, 0.0f);
        primitive_attr with_elu;
        with_elu.set_post_ops(elu);
        const memory::desc weights = {{to, channels[k], 3, 3}, memory::data_type::f32, Tag::any};
        const memory::desc bias = {{to}, memory::data_type::f32, Tag::x};
        const convolution_forward::desc convolution(prop_kind::forward_inference, algorithm::convolution_direct,
                                                    k == 0 ? now.get_desc() : image(channels[k], side, Tag::any),
                                                    weights, bias, image(to, side, Tag::any), {1, 1}, {1, 1}, {1, 1});
        const convolution_forward::primitive_desc plan(convolution, with_elu, cpu);
        if (plan.src_desc() != now.get_desc()) {
            memory other(plan.src_desc(), cpu);
            calls.push_back({reorder(now, other), {{DNNL_ARG_FROM, now}, {DNNL_ARG_TO, other}}});
            now = other;
        }
        memory wide(plan.dst_desc(), cpu);
        calls.push_back({convolution_forward(plan),
                         {{DNNL_ARG_SRC, now},
                          {DNNL_ARG_WEIGHTS, memory(plan.weights_desc(), cpu)},
                          {DNNL_ARG_BIAS, memory(plan.bias_desc(), cpu)},
                          {DNNL_ARG_DST, wide}}});
        const pooling_forward::desc pooling(prop_kind::forward_inference, algorithm::pooling_max, wide.get_desc(),
                                            image(to, side / 2, Tag::any), {2, 2}, {2, 2}, {0, 0}, {0, 0});
        const pooling_forward::primitive_desc pool(pooling, cpu);
        memory narrow(pool.dst_desc(), cpu);
        calls.push_back({pooling_forward(pool), {{DNNL_ARG_SRC, wide}, {DNNL_ARG_DST, narrow}}});
        now = narrow;
    }
    const inner_product_forward::desc dense(prop_kind::forward_inference, now.get_desc(),
                                            {{1, 64, 16, 16}, memory::data_type::f32, Tag::any},
                                            {{1, 1}, memory::data_type::f32, Tag::nc});
    const inner_product_forward::primitive_desc plan(dense, cpu);
    calls.push_back({inner_product_forward(plan),
                     {{DNNL_ARG_SRC, now},
                      {DNNL_ARG_WEIGHTS, memory(plan.weights_desc(), cpu)},
                      {DNNL_ARG_DST, memory(plan.dst_desc(), cpu)}}});
    const timing time = measure(9, 20, [&] {
        for (const Call &call : calls)
            call.what.execute(order, call.with);
        order.wait();
    });
    const version_t *v = version();
    std::printf("{\"part\": \"peer\", \"peer\": \"oneDNN %d.%d\", \"layout\": \"paper\", \"encode_ms\": %.4f}\n",
                v->major, v->minor, time.median * 1e3);
}
