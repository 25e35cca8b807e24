// Voro++: cells with volumes and centroids of the sites in a file, in the unit cube.
// Prints CPU microseconds per site and the sum of the volumes.
#include <cmath>
#include <cstdio>
#include <ctime>
#include <vector>
#include <voro++.hh>

int main(int, char **arguments) {
    std::FILE *file = std::fopen(arguments[1], "r");
    if (!file) return 1;
    std::vector<double> sites;
    double x, y, z;
    if (std::fscanf(file, "%*[^\n]") != 0) return 1;
    while (std::fscanf(file, "%lf,%lf,%lf", &x, &y, &z) == 3) {
        sites.insert(sites.end(), {x, y, z});
    }
    std::fclose(file);
    const int count = sites.size() / 3;
    const std::clock_t began = std::clock();
    // 5.6 sites a block: the library's own choice (optimal_particles).
    const int blocks = std::max(1, (int)(std::cbrt(count / voro::optimal_particles) + 0.5));
    voro::container container(0, 1, 0, 1, 0, 1, blocks, blocks, blocks, false, false, false, 8);
    for (int site = 0; site < count; ++site) {
        container.put(site, sites[3 * site], sites[3 * site + 1], sites[3 * site + 2]);
    }
    double volume = 0, center = 0;
    voro::c_loop_all loop(container);
    voro::voronoicell cell;
    if (loop.start()) do {
        if (container.compute_cell(cell, loop)) {
            volume += cell.volume();
            cell.centroid(x, y, z);
            center += x + y + z;
        }
    } while (loop.inc());
    const double seconds = double(std::clock() - began) / CLOCKS_PER_SEC;
    std::printf("%.3f %.15g %g\n", 1e6 * seconds / count, volume, center);
}
