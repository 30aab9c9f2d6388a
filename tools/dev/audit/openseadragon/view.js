// SPDX-License-Identifier: Apache-2.0
// Opens FOLDER/wall.dzi with OpenSeadragon, goes through the views, and writes for each a screenshot FOLDER/seen_NAME.png and, into
// FOLDER/views.json, the rectangle of texture coordinates that OpenSeadragon says it shows.
'use strict';
const fs = require('fs');
const http = require('http');
const path = require('path');
const {chromium} = require('playwright-core');

const folder = path.resolve(process.argv[2]);
const SIZE = {width: 1024, height: 512}; // of the window, in the shape of the texture
// Where to, by OpenSeadragon's own functions: widths of the picture, from its corner.
const VIEWS = {
    home: 'viewer.viewport.goHome(true)',
    half: 'viewer.viewport.fitBounds(new OpenSeadragon.Rect(0.375, 0.0625, 0.5, 0.25), true)',
    patch: 'viewer.viewport.fitBounds(new OpenSeadragon.Rect(0.5625, 0.15625, 0.125, 0.0625), true)',
    edge: 'viewer.viewport.fitBounds(new OpenSeadragon.Rect(0.46875, 0.109375, 0.125, 0.0625), true)',
    between: 'viewer.viewport.fitBounds(new OpenSeadragon.Rect(0.3137, 0.1111, 0.3032, 0.1516), true)',
};
const TYPES = {'.html': 'text/html', '.js': 'text/javascript', '.dzi': 'application/xml', '.png': 'image/png'};
const PAGE = `<!doctype html><title>wall</title><style>html, body, #view {margin: 0; width: 100%; height: 100%; background: #000}</style>
<div id="view"></div><script src="node_modules/openseadragon/build/openseadragon/openseadragon.min.js"></script>
<script>const viewer = OpenSeadragon({id: 'view', tileSources: 'wall.dzi', showNavigationControl: false, drawer: 'canvas',
    immediateRender: true, animationTime: 0, blendTime: 0, visibilityRatio: 0, homeFillsViewer: true});
viewer.failures = [];
viewer.addHandler('open-failed', event => viewer.failures.push(event.message));
viewer.addHandler('tile-load-failed', event => viewer.failures.push(event.message));</script>`;

function serve(request, response) {
    const name = decodeURIComponent(new URL(request.url, 'http://localhost').pathname);
    const file = path.join(folder, name);
    const headers = {'Content-Type': TYPES[path.extname(file)] || 'application/octet-stream'};
    if (name === '/index.html')
        response.writeHead(200, headers).end(PAGE);
    else if (file.startsWith(folder + path.sep) && fs.existsSync(file) && fs.statSync(file).isFile())
        response.writeHead(200, headers).end(fs.readFileSync(file));
    else
        response.writeHead(404).end();
}

async function show(page, name, how) {
    await page.evaluate(how);
    await page.waitForFunction(() => viewer.failures.length > 0 ||
        (viewer.world.getItemCount() === 1 && viewer.world.getItemAt(0).getFullyLoaded()));
    // Drawn once more after the last tile.
    await page.evaluate(() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))));
    await page.screenshot({path: path.join(folder, `seen_${name}.png`)});
    return page.evaluate(() => {
        const bounds = viewer.viewport.getBounds(true), image = viewer.world.getItemAt(0).getBounds();
        return {view: [bounds.x, bounds.y / image.height, bounds.x + bounds.width, (bounds.y + bounds.height) / image.height],
            zoom: viewer.viewport.viewportToImageZoom(viewer.viewport.getZoom(true)), failures: viewer.failures};
    });
}

async function main() {
    const server = http.createServer(serve).listen(0, '127.0.0.1');
    await new Promise(done => server.once('listening', done));
    const flags = ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
        '--disable-component-update', '--disable-sync'];
    const browser = await chromium.launch({executablePath: '/usr/bin/chromium', headless: true, args: flags});
    try {
        const page = await browser.newPage({viewport: SIZE, deviceScaleFactor: 1});
        await page.goto(`http://127.0.0.1:${server.address().port}/index.html`);
        await page.waitForFunction(() => viewer.isOpen() || viewer.failures.length > 0);
        const views = {};
        for (const [name, how] of Object.entries(VIEWS))
            views[name] = await show(page, name, how);
        const about = await page.evaluate(() => OpenSeadragon.version.versionStr);
        fs.writeFileSync(path.join(folder, 'views.json'), JSON.stringify({size: SIZE, version: about, browser: browser.version(), views}, null, 1));
    } finally {
        await browser.close();
        server.close();
    }
}

main().catch(error => {
    console.error(`audit openseadragon: ${error.message}`);
    process.exit(1);
});
