// Finds what was typed in SECTIONS (search-index.js), rows of address, page, heading, text: all words, anywhere.
const MOST = 50, AROUND = 90; // results shown, characters around the first word found
const plain = (text) => text.normalize("NFKC").toLowerCase();
const texts = SECTIONS.map((row) => row.slice(1).map(plain));

function found(query) {
    const whole = plain(query).trim(), words = whole.split(/\s+/).filter(Boolean);
    const scored = texts.map(([page, heading, text], i) => {
        if (!words.length || !words.every((word) => page.includes(word) || text.includes(word))) return [0, i];
        const places = words.filter((word) => heading.includes(word)).length + words.filter((word) => page.includes(word)).length;
        const times = text.split(whole).length - 1; // the words as they were typed, one after the other
        return [1 + 20 * (heading.includes(whole) + page.includes(whole)) + 4 * places + (times ? 6 + Math.min(times, 5) : 0), i];
    });
    return scored.filter(([score]) => score).sort((a, b) => b[0] - a[0] || a[1] - b[1]).map(([, i]) => i);
}

// The text around the first word, which is marked.
function excerpt(i, query) {
    const text = SECTIONS[i][3], low = texts[i][2], paragraph = document.createElement("p");
    const whole = plain(query).trim(), word = [whole, ...whole.split(/\s+/)].find((each) => low.includes(each)) || "";
    const at = Math.max(low.indexOf(word), 0), from = Math.max(0, at - AROUND), mark = document.createElement("mark");
    mark.textContent = text.slice(at, at + word.length);
    paragraph.append(from ? "…" : "", text.slice(from, at), mark, text.slice(at + word.length, at + word.length + AROUND), "…");
    return paragraph;
}

function show(query) {
    const results = found(query), list = document.getElementById("results");
    list.replaceChildren(...results.slice(0, MOST).map((i) => {
        const [url, page, heading] = SECTIONS[i], item = document.createElement("li"), link = document.createElement("a");
        link.href = url;
        link.textContent = heading && heading !== page ? `${page} › ${heading}` : page;
        item.append(link, excerpt(i, query));
        return item;
    }));
    const first = results.length > MOST ? `, the first ${MOST} of them` : "";
    document.getElementById("count").textContent = `${results.length || "No"} ${results.length === 1 ? "place" : "places"} with “${query}”${first}.`;
}

const query = new URLSearchParams(location.search).get("q") || "";
const box = document.getElementById("query");
box.value = query;
box.oninput = () => show(box.value);
if (query) show(query);
