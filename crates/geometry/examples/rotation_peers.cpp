// Eigen's six conversions, for rotation_peers.py, which says how to compile and run this.
//
// Each line of the input is a conversion, such as w>q, and its numbers as C hex floats; each line of the output is the
// result. The line `time` prints the ns per call of each conversion, the least of 60 batches of 200 random rotations.

#include <Eigen/Geometry>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Numbers = std::vector<double>;
using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// The documented way to an exponential: angle and axis, the axis by `normalized`, which leaves zero as it is.
static AngleAxisd turn(const Vector3d& w) { return AngleAxisd(w.norm(), w.normalized()); }
static Vector3d vector(const AngleAxisd& a) { return a.angle() * a.axis(); }

static Vector3d w_of(const Numbers& n) { return Vector3d(n[0], n[1], n[2]); }
static Quaterniond q_of(const Numbers& n) { return Quaterniond(n[0], n[1], n[2], n[3]); }
static Matrix3d m_of(const Numbers& n) { return Eigen::Map<const RowMajor>(n.data()); }
static Numbers out(const Vector3d& w) { return {w[0], w[1], w[2]}; }
static Numbers out(const Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }
static Numbers out(const Matrix3d& m) {
    RowMajor rows = m;
    return Numbers(rows.data(), rows.data() + 9);
}

static Quaterniond w_q(const Vector3d& w) { return Quaterniond(turn(w)); }
static Matrix3d w_m(const Vector3d& w) { return turn(w).toRotationMatrix(); }
static Vector3d q_w(const Quaterniond& q) { return vector(AngleAxisd(q)); }
static Matrix3d q_m(const Quaterniond& q) { return q.toRotationMatrix(); }
static Quaterniond m_q(const Matrix3d& m) { return Quaterniond(m); }
static Vector3d m_w(const Matrix3d& m) { return vector(AngleAxisd(m)); }

static const std::map<std::string, std::function<Numbers(const Numbers&)>> conversions = {
    {"w>q", [](const Numbers& n) { return out(w_q(w_of(n))); }},
    {"w>M", [](const Numbers& n) { return out(w_m(w_of(n))); }},
    {"q>w", [](const Numbers& n) { return out(q_w(q_of(n))); }},
    {"q>M", [](const Numbers& n) { return out(q_m(q_of(n))); }},
    {"M>q", [](const Numbers& n) { return out(m_q(m_of(n))); }},
    {"M>w", [](const Numbers& n) { return out(m_w(m_of(n))); }},
};

template <class T>
static void keep(const T& value) {
    asm volatile("" : : "r"(&value) : "memory");
}

template <class I, class F>
static void clock(const char* name, const std::vector<I>& inputs, F call) {
    double least = 1e9;
    for (int batch = 0; batch < 60; ++batch) {
        const auto start = std::chrono::steady_clock::now();
        for (int i = 0; i < 20; ++i) {
            for (const I& input : inputs) {
                keep(input);
                keep(call(input));
            }
        }
        const std::chrono::duration<double, std::nano> passed = std::chrono::steady_clock::now() - start;
        least = std::min(least, passed.count() / (20.0 * inputs.size()));
    }
    std::printf("%s %.1f\n", name, least);
}

static void clock_all() {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> one(-1.8, 1.8);
    std::vector<Vector3d> w;
    std::vector<Quaterniond> q;
    std::vector<Matrix3d> m;
    for (int i = 0; i < 200; ++i) {
        w.emplace_back(one(random), one(random), one(random));
        q.push_back(w_q(w.back()));
        m.push_back(w_m(w.back()));
    }
    clock("w>q", w, w_q);
    clock("w>M", w, w_m);
    clock("q>w", q, q_w);
    clock("q>M", q, q_m);
    clock("M>q", m, m_q);
    clock("M>w", m, m_w);
}

int main() {
    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream words(line);
        std::string name, number;
        words >> name;
        if (name == "time") {
            clock_all();
            continue;
        }
        Numbers numbers;
        while (words >> number) numbers.push_back(std::strtod(number.c_str(), nullptr));
        for (double x : conversions.at(name)(numbers)) std::printf("%a ", x);
        std::printf("\n");
    }
}
