// SPDX-License-Identifier: Apache-2.0
// The module ztex-vision: author_vision.h out of OpenCV. No exception leaves it.
#include "author_vision.h"
#include "author.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <mutex>
#include <numeric>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/flann.hpp>

namespace {

using Index = cv::flann::GenericIndex<cvflann::L2<float>>;
using ByteIndex = cv::flann::GenericIndex<cvflann::L2<unsigned char>>;

constexpr int kLength = AUTHOR_DESCRIPTOR;
constexpr int kTrees = 4;       // of the index
constexpr int kChecks = 32;     // leaves that one search looks at
constexpr int kSeed = 20100214; // of everything that OpenCV draws by chance

// Beside one thread of ours OpenCV starts none: so the order of its results is always the same.
void useOneThread() {
    static std::once_flag once;
    std::call_once(once, [] { cv::setNumThreads(1); });
}

int failed(char *error, const char *what, const char *why) {
    std::snprintf(error, AUTHOR_ERROR, "OpenCV cannot %s: %.200s", what, why);
    return -1;
}

// Runs work, and turns what it throws into a line of text.
template <typename Work> int guarded(char *error, const char *what, const Work &work) {
    try {
        useOneThread();
        work();
        return 0;
    } catch (const std::exception &problem) {
        return failed(error, what, problem.what());
    } catch (...) {
        return failed(error, what, "unknown error");
    }
}

} // namespace

struct author_features {
    std::vector<author_point> points;
    cv::Mat descriptors; // a row of floats for each point
    std::unique_ptr<Index> index;
};

struct author_index {
    cv::Mat rows;
    std::unique_ptr<ByteIndex> index;
};

namespace {

// Square roots of shares: the Euclidean distance then compares histograms (Arandjelovic and Zisserman 2012).
void rootNormalise(float *descriptor) {
    float sum = std::accumulate(descriptor, descriptor + kLength, 0.0F);
    float scale = sum > 0 ? 1 / sum : 0;
    for (int i = 0; i < kLength; i++)
        descriptor[i] = std::sqrt(descriptor[i] * scale);
}

// SIFT of OpenCV 4.6 puts every feature 0.25 pixels too far right and down; its pixel centres are whole numbers.
author_point pointOf(const cv::KeyPoint &key) {
    return {key.pt.x + 0.25F, key.pt.y + 0.25F, key.size, key.angle};
}

void detectInto(author_features &out, const cv::Mat &grey, int most) {
    constexpr int layers = 3;
    constexpr double contrast = 0.012, edge = 12, sigma = 1.6;
    auto sift = cv::SIFT::create(most, layers, contrast, edge, sigma);
    std::vector<cv::KeyPoint> keys;
    cv::Mat found;
    sift->detectAndCompute(grey, cv::noArray(), keys, found);
    std::vector<int> order(keys.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
        return keys[static_cast<size_t>(a)].size > keys[static_cast<size_t>(b)].size;
    });
    out.descriptors.create(static_cast<int>(keys.size()), kLength, CV_32F);
    for (int i = 0; i < static_cast<int>(order.size()); i++) {
        int from = order[static_cast<size_t>(i)];
        out.points.push_back(pointOf(keys[static_cast<size_t>(from)]));
        std::copy_n(found.ptr<float>(from), kLength, out.descriptors.ptr<float>(i));
        rootNormalise(out.descriptors.ptr<float>(i));
    }
}

void buildIndex(author_features &features) {
    if (features.descriptors.rows < 2)
        return;
    cv::theRNG() = cv::RNG(kSeed);
    features.index = std::make_unique<Index>(features.descriptors, cvflann::KDTreeIndexParams(kTrees));
}

float ratioOf(float nearest, float second) {
    return second > 0 ? std::sqrt(nearest / second) : 1;
}

int detect(const uint8_t *grey, uint32_t width, uint32_t height, uint32_t most, author_features **out, char *error) {
    *out = nullptr;
    return guarded(error, "find features", [&] {
        auto features = std::make_unique<author_features>();
        const cv::Mat picture(static_cast<int>(height), static_cast<int>(width), CV_8U, const_cast<uint8_t *>(grey));
        detectInto(*features, picture, static_cast<int>(most));
        buildIndex(*features);
        *out = features.release();
    });
}

void release(author_features *features) {
    delete features;
}

const author_point *points(const author_features *features, size_t *count) {
    *count = features->points.size();
    return features->points.data();
}

int match(const author_features *query, size_t query_count, const author_features *train, author_match *out,
          size_t *count, char *error) {
    *count = 0;
    return guarded(error, "match features", [&] {
        int rows = std::min(static_cast<int>(query_count), query->descriptors.rows);
        if (!train->index || rows == 0)
            return;
        cv::Mat indices(rows, 2, CV_32S), distances(rows, 2, CV_32F);
        train->index->knnSearch(query->descriptors.rowRange(0, rows), indices, distances, 2,
                                cvflann::SearchParams(kChecks));
        for (int i = 0; i < rows; i++) {
            int nearest = indices.at<int>(i, 0);
            if (nearest < 0 || nearest >= train->descriptors.rows)
                continue;
            float ratio = ratioOf(distances.at<float>(i, 0), distances.at<float>(i, 1));
            out[(*count)++] = {static_cast<uint32_t>(i), static_cast<uint32_t>(nearest), ratio};
        }
    });
}

float distanceOf(const float *a, const float *b) {
    float sum = 0;
    for (int i = 0; i < kLength; i++)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum;
}

// Features in cells of a square grid, so that those near a place are found without looking at all.
class Grid {
  public:
    Grid(const std::vector<author_point> &points, double cell) : m_points(points), m_cell(cell) {
        for (const author_point &p : points) {
            m_columns = std::max(m_columns, column(p.x) + 1);
            m_rows = std::max(m_rows, column(p.y) + 1);
        }
        m_cells.resize(static_cast<size_t>(m_columns) * static_cast<size_t>(m_rows));
        for (size_t i = 0; i < points.size(); i++)
            at(column(points[i].x), column(points[i].y)).push_back(static_cast<uint32_t>(i));
    }

    template <typename Visit> void near(double x, double y, double radius, const Visit &visit) {
        int right = std::min(m_columns - 1, column(x + radius)), bottom = std::min(m_rows - 1, column(y + radius));
        for (int r = std::max(0, column(y - radius)); r <= bottom; r++)
            for (int c = std::max(0, column(x - radius)); c <= right; c++)
                visitCell(at(c, r), x, y, radius, visit);
    }

  private:
    template <typename Visit>
    void visitCell(const std::vector<uint32_t> &cell, double x, double y, double radius, const Visit &visit) {
        for (uint32_t i : cell)
            if (std::hypot(m_points[i].x - x, m_points[i].y - y) <= radius)
                visit(i);
    }
    int column(double x) const {
        return std::max(0, static_cast<int>(x / m_cell));
    }
    std::vector<uint32_t> &at(int c, int r) {
        return m_cells[static_cast<size_t>(r) * static_cast<size_t>(m_columns) + static_cast<size_t>(c)];
    }

    const std::vector<author_point> &m_points;
    double m_cell;
    int m_columns = 1, m_rows = 1;
    std::vector<std::vector<uint32_t>> m_cells;
};

bool looksAlike(const author_point &a, const author_point &b) {
    constexpr float size = 1.6F, angle = 35;
    float turn = std::fabs(a.angle - b.angle);
    turn = std::min(turn, 360 - turn);
    return a.size < b.size * size && b.size < a.size * size && turn < angle;
}

// The best of the features near a place, and how it compares with the best that lies elsewhere.
struct Best {
    float nearest = HUGE_VALF, second = HUGE_VALF;
    uint32_t index = 0;

    void offer(const std::vector<author_point> &all, uint32_t i, float distance) {
        constexpr float same = 2; // pixels
        bool elsewhere = nearest == HUGE_VALF || std::hypot(all[i].x - all[index].x, all[i].y - all[index].y) > same;
        if (distance >= nearest) {
            if (elsewhere)
                second = std::min(second, distance);
            return;
        }
        if (elsewhere)
            second = nearest;
        nearest = distance;
        index = i;
    }
};

int matchNear(const author_features *query, const author_features *train, double radius, author_match *out,
              size_t *count, char *error) {
    *count = 0;
    return guarded(error, "match features", [&] {
        Grid grid(train->points, std::max(radius, 1.0));
        for (size_t q = 0; q < query->points.size(); q++) {
            const author_point &p = query->points[q];
            const float *own = query->descriptors.ptr<float>(static_cast<int>(q));
            Best best;
            grid.near(p.x, p.y, radius, [&](uint32_t i) {
                if (looksAlike(p, train->points[i]))
                    best.offer(train->points, i, distanceOf(own, train->descriptors.ptr<float>(static_cast<int>(i))));
            });
            if (best.nearest < HUGE_VALF)
                out[(*count)++] = {static_cast<uint32_t>(q), best.index,
                                   best.second < HUGE_VALF ? ratioOf(best.nearest, best.second) : 0};
        }
    });
}

cv::UsacParams robustParameters(double reach) {
    cv::UsacParams parameters;
    parameters.confidence = 0.9999;
    parameters.isParallel = false;
    parameters.maxIterations = 20000;
    parameters.randomGeneratorState = kSeed;
    parameters.sampler = cv::SAMPLING_UNIFORM;
    parameters.score = cv::SCORE_METHOD_MAGSAC;
    parameters.loMethod = cv::LOCAL_OPTIM_SIGMA;
    parameters.loIterations = 10;
    parameters.loSampleSize = 50;
    parameters.threshold = reach;
    return parameters;
}

int homography(const double *from, const double *to, size_t count, double reach, double matrix[9], uint8_t *inlier,
               int *found, char *error) {
    *found = 0;
    return guarded(error, "fit a homography", [&] {
        int rows = static_cast<int>(count);
        const cv::Mat a(rows, 2, CV_64F, const_cast<double *>(from)), b(rows, 2, CV_64F, const_cast<double *>(to));
        cv::Mat mask;
        cv::Mat h = cv::findHomography(a, b, mask, robustParameters(reach));
        if (h.rows != 3 || h.cols != 3 || mask.total() != count)
            return;
        std::copy_n(h.ptr<double>(), 9, matrix);
        for (int i = 0; i < rows; i++)
            inlier[i] = mask.at<uint8_t>(i) != 0;
        *found = 1;
    });
}

// ---- an index over many pictures ------------------------------------------------------------------------------

const float *descriptors(const author_features *features) {
    return features->descriptors.ptr<float>();
}

cv::Mat matrixOf(const uint8_t *rows, size_t count) {
    return {static_cast<int>(count), kLength, CV_8U, const_cast<uint8_t *>(rows)};
}

int createIndex(const uint8_t *rows, size_t count, author_index **out, char *error) {
    constexpr int trees = 2; // more take memory and hardly find more
    *out = nullptr;
    return guarded(error, "index features", [&] {
        auto made = std::make_unique<author_index>();
        made->rows = matrixOf(rows, count);
        cv::theRNG() = cv::RNG(kSeed);
        if (count > 1)
            made->index = std::make_unique<ByteIndex>(made->rows, cvflann::KDTreeIndexParams(trees));
        *out = made.release();
    });
}

void releaseIndex(author_index *index) {
    delete index;
}

int searchIndex(const author_index *index, const uint8_t *queries, size_t query_count, uint32_t most, uint32_t *numbers,
                float *squares, char *error) {
    constexpr int checks = 128;
    return guarded(error, "look features up", [&] {
        std::fill_n(numbers, query_count * most, UINT32_MAX);
        if (!index->index || query_count == 0)
            return;
        int rows = static_cast<int>(query_count), found = std::min(static_cast<int>(most), index->rows.rows);
        cv::Mat places(rows, found, CV_32S), distances(rows, found, CV_32F);
        index->index->knnSearch(matrixOf(queries, query_count), places, distances, found,
                                cvflann::SearchParams(checks));
        for (int i = 0; i < rows; i++)
            for (int k = 0; k < found; k++) {
                int place = places.at<int>(i, k);
                size_t at = static_cast<size_t>(i) * most + static_cast<size_t>(k);
                if (place >= 0 && place < index->rows.rows) {
                    numbers[at] = static_cast<uint32_t>(place);
                    squares[at] = distances.at<float>(i, k);
                }
            }
    });
}

} // namespace

extern "C" {
extern __attribute__((visibility("default"))) const author_vision ztex_vision_module;
const author_vision ztex_vision_module = {
    sizeof(author_vision), detect,      release,      points,      match, matchNear, homography,
    descriptors,           createIndex, releaseIndex, searchIndex,
};
}
