// Nearest and any hits by Embree 3 or 4, on one core: the peer of `cargo bench --bench embree`.
//
// Reads a mesh, then the rays of one file per kind. For each line "KIND MODE" on standard input it
// traces the rays of that kind once and prints the seconds, the number of hits and the sum of their
// distances.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace {

// As the bench writes it, in the machine's byte order.
struct Ray {
    float origin[3];
    float direction[3];
    float end;
};

struct Result {
    double seconds;
    size_t hits;
    double sum;
};

template <typename T> T read_one(std::ifstream &file) {
    T value{};
    file.read(reinterpret_cast<char *>(&value), sizeof value);
    return value;
}

std::ifstream open_file(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        std::fprintf(stderr, "cannot open %s\n", path.c_str());
        std::exit(2);
    }
    return file;
}

RTCScene build(RTCDevice device, const std::string &path, bool robust) {
    std::ifstream file = open_file(path);
    const uint32_t vertices = read_one<uint32_t>(file), triangles = read_one<uint32_t>(file);
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto fill = [&](RTCBufferType type, RTCFormat format, uint32_t count) {
        void *data = rtcSetNewGeometryBuffer(mesh, type, 0, format, 12, count);
        file.read(static_cast<char *>(data), 12 * std::streamsize(count));
    };
    fill(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, vertices);
    fill(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, triangles);
    rtcSetGeometryBuildQuality(mesh, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(mesh);
    RTCScene scene = rtcNewScene(device);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    rtcSetSceneFlags(scene, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcCommitScene(scene);
    return scene;
}

std::vector<Ray> read_rays(const std::string &path) {
    std::ifstream file = open_file(path);
    std::vector<Ray> rays(read_one<uint32_t>(file));
    file.read(reinterpret_cast<char *>(rays.data()), std::streamsize(rays.size() * sizeof(Ray)));
    return rays;
}

#if RTC_VERSION_MAJOR >= 4
struct Query {
    RTCIntersectArguments nearest;
    RTCOccludedArguments any;
    explicit Query(bool coherent) {
        rtcInitIntersectArguments(&nearest);
        rtcInitOccludedArguments(&any);
        const RTCRayQueryFlags flags =
            coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
        nearest.flags = any.flags = flags;
    }
    void intersect(RTCScene s, const int *, RTCRayHit &r) { rtcIntersect1(s, &r, &nearest); }
    void intersect(RTCScene s, const int *v, RTCRayHit8 &r) { rtcIntersect8(v, s, &r, &nearest); }
    void intersect(RTCScene s, const int *v, RTCRayHit16 &r) { rtcIntersect16(v, s, &r, &nearest); }
    void occlude(RTCScene s, const int *, RTCRay &r) { rtcOccluded1(s, &r, &any); }
    void occlude(RTCScene s, const int *v, RTCRay8 &r) { rtcOccluded8(v, s, &r, &any); }
    void occlude(RTCScene s, const int *v, RTCRay16 &r) { rtcOccluded16(v, s, &r, &any); }
};
#else
struct Query {
    RTCIntersectContext context;
    explicit Query(bool coherent) {
        rtcInitIntersectContext(&context);
        context.flags =
            coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    }
    void intersect(RTCScene s, const int *, RTCRayHit &r) { rtcIntersect1(s, &context, &r); }
    void intersect(RTCScene s, const int *v, RTCRayHit8 &r) { rtcIntersect8(v, s, &context, &r); }
    void intersect(RTCScene s, const int *v, RTCRayHit16 &r) { rtcIntersect16(v, s, &context, &r); }
    void occlude(RTCScene s, const int *, RTCRay &r) { rtcOccluded1(s, &context, &r); }
    void occlude(RTCScene s, const int *v, RTCRay8 &r) { rtcOccluded8(v, s, &context, &r); }
    void occlude(RTCScene s, const int *v, RTCRay16 &r) { rtcOccluded16(v, s, &context, &r); }
};
#endif

// Lane `i` of a member that is a single number, or an array of them.
float &lane(float &member, int) { return member; }
unsigned &lane(unsigned &member, int) { return member; }
template <typename T, size_t N> T &lane(T (&member)[N], int i) { return member[i]; }

template <typename R> void set(R &to, int i, const Ray &ray) {
    lane(to.org_x, i) = ray.origin[0];
    lane(to.org_y, i) = ray.origin[1];
    lane(to.org_z, i) = ray.origin[2];
    lane(to.dir_x, i) = ray.direction[0];
    lane(to.dir_y, i) = ray.direction[1];
    lane(to.dir_z, i) = ray.direction[2];
    lane(to.tnear, i) = 0.0f;
    lane(to.tfar, i) = ray.end;
    lane(to.time, i) = 0.0f;
    lane(to.mask, i) = ~0u;
    lane(to.id, i) = 0;
    lane(to.flags, i) = 0;
}

template <typename F> double seconds_of(F work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Rays are laid out before the clock starts, and hits are counted after it stops.
template <typename H, int N> Result nearest(RTCScene scene, const std::vector<Ray> &rays, bool coherent) {
    std::vector<H> packets((rays.size() + N - 1) / N);
    int valid[N];
    std::fill(valid, valid + N, -1);
    for (size_t i = 0; i < packets.size() * N; i++) {
        H &packet = packets[i / N];
        set(packet.ray, int(i % N), rays[std::min(i, rays.size() - 1)]);
        lane(packet.hit.geomID, int(i % N)) = RTC_INVALID_GEOMETRY_ID;
        lane(packet.hit.instID[0], int(i % N)) = RTC_INVALID_GEOMETRY_ID;
    }
    Query query(coherent);
    Result result{};
    result.seconds = seconds_of([&] {
        for (H &packet : packets) query.intersect(scene, valid, packet);
    });
    for (size_t i = 0; i < rays.size(); i++) {
        H &packet = packets[i / N];
        if (lane(packet.hit.geomID, int(i % N)) != RTC_INVALID_GEOMETRY_ID) {
            result.hits++;
            result.sum += lane(packet.ray.tfar, int(i % N));
        }
    }
    return result;
}

template <typename P, int N> Result any(RTCScene scene, const std::vector<Ray> &rays, bool coherent) {
    std::vector<P> packets((rays.size() + N - 1) / N);
    int valid[N];
    std::fill(valid, valid + N, -1);
    for (size_t i = 0; i < packets.size() * N; i++)
        set(packets[i / N], int(i % N), rays[std::min(i, rays.size() - 1)]);
    Query query(coherent);
    Result result{};
    result.seconds = seconds_of([&] {
        for (P &packet : packets) query.occlude(scene, valid, packet);
    });
    for (size_t i = 0; i < rays.size(); i++)
        result.hits += lane(packets[i / N].tfar, int(i % N)) < 0.0f;
    return result;
}

} // namespace

// Arguments: mesh, then NAME=FILE for each kind of rays. A kind named "shadow" asks for any hit.
int main(int count, char **arguments) {
    if (count < 3) {
        std::fprintf(stderr, "usage: %s MESH KIND=RAYS...\n", arguments[0]);
        return 2;
    }
    RTCDevice device = rtcNewDevice("threads=1,set_affinity=0");
    RTCScene scenes[2] = {build(device, arguments[1], false), build(device, arguments[1], true)};
    std::map<std::string, std::vector<Ray>> kinds;
    for (int i = 2; i < count; i++) {
        const std::string argument = arguments[i];
        const size_t equals = argument.find('=');
        kinds[argument.substr(0, equals)] = read_rays(argument.substr(equals + 1));
    }
    std::cout << RTC_VERSION_STRING << std::endl;
    std::string kind, mode;
    int robust;
    while (std::cin >> kind >> mode >> robust) {
        const std::vector<Ray> &rays = kinds.at(kind);
        RTCScene scene = scenes[robust];
        const bool is_any = kind == "shadow", coherent = kind == "camera";
        Result result{};
        if (mode == "1")
            result = is_any ? any<RTCRay, 1>(scene, rays, coherent) : nearest<RTCRayHit, 1>(scene, rays, coherent);
        else if (mode == "8")
            result = is_any ? any<RTCRay8, 8>(scene, rays, coherent) : nearest<RTCRayHit8, 8>(scene, rays, coherent);
        else
            result = is_any ? any<RTCRay16, 16>(scene, rays, coherent) : nearest<RTCRayHit16, 16>(scene, rays, coherent);
        std::printf("%.9f %zu %.9g\n", result.seconds, result.hits, result.sum);
        std::fflush(stdout);
    }
    return 0;
}
